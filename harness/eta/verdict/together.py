"""A measure under two rewards, means over several places."""

import math
from dataclasses import dataclass
from functools import cached_property

from harness.eta.behaviour_change import Measure
from harness.eta.interval import UNSEEN, Interval, binomial_variance, quantile, why_no_interval
from harness.eta.verdict.question import LEAST_SEEDS, Question


@dataclass(frozen=True, eq=False)
class Together:
    """Means over places of one measure.

    Attributes:
        measure: What is measured, the same in all places.
        question: The values as they were measured, of this measure alone.
    """

    measure: Measure
    question: Question

    @property
    def name(self) -> str:
        """The name of the metric."""
        return self.measure.name

    @property
    def baseline(self) -> float:
        """The mean over seeds and places under the baseline."""
        return self.question.means[0]

    @property
    def proposed(self) -> float:
        """The same under the proposed reward."""
        return self.question.means[1]

    @property
    def seeds(self) -> int:
        """The fewest seeds in a place."""
        return self.question.seeds

    @property
    def lowest(self) -> float:
        """The lowest value of a seed in a place, under either reward."""
        return float(self.question.values[self.question.known].min())

    @property
    def low(self) -> float | None:
        """The lower end of the 95 % interval of proposed - baseline; None below three seeds."""
        found = self._interval(0.95)
        return found and found[0]

    @property
    def high(self) -> float | None:
        """The upper end."""
        found = self._interval(0.95)
        return found and found[1]

    @property
    def likely(self) -> Interval | None:
        """The 90 % interval."""
        return self._interval(0.90)

    @property
    def spread(self) -> float | None:
        """The standard deviation of one seed's mean over all places; None below two seeds."""
        return math.sqrt(self._variance / 2.0) if self.seeds >= LEAST_SEEDS else None

    @cached_property
    def _variance(self) -> float:
        """The variance of a seed's difference, means over places.

        Of a share it allows for the seed that was not seen, see `harness.eta.interval.share_variance`: one in one of
        the places, so the more there are, the less it counts.
        """
        seeds, places = self.seeds, self.question.places
        seen = self.question.estimate().error ** 2 * seeds
        if self.measure.episodes is None:
            return seen
        floor = sum(binomial_variance(mean, self.measure.episodes) for mean in self.question.means) / places
        seen = max(seen, floor)
        return max(seen, ((seeds - 1) * seen + UNSEEN**2 / places) / seeds)

    def _interval(self, confidence: float) -> Interval | None:
        if why_no_interval(self.seeds):
            return None
        reach = quantile(confidence, self.seeds - 1) * math.sqrt(self._variance / self.seeds)
        difference = self.proposed - self.baseline
        low, high = self.measure.of_difference
        return max(difference - reach, min(low, difference)), min(difference + reach, max(high, difference))
