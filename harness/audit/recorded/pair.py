"""Two rewards over several sets of recorded steps: the means of their distances."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from harness.audit.recorded.paid import Apart
from harness.eta.interval import SHARE
from harness.eta.rescaling import Line, Rescaling, rescaling_of
from harness.eta.seed_mean import SeedMean, mean_over_seeds

if TYPE_CHECKING:
    from harness.audit.recorded.step_apart import StepApart


@dataclass(frozen=True)
class Pair:
    """How far apart two rewards are. Every number is a mean over recordings or over measurements.

    Attributes:
        one: A reward.
        other: Another one.
        steps: Pearson distance of what they pay for each step, see `harness.audit.recorded.paid.Apart`.
        returns: The same of the returns of episodes.
        discordant: Share of pairs of episodes that they put in opposite orders, of those that both tell apart.
        told_apart: Share of all pairs of episodes that both tell apart.
        each: What the means are made of, by recording or measurement.
        rescaling: What the other one is, if it is the first one but for scale and offset; else None.
        largest: The steps that they pay most differently; empty where they were not looked for.
    """

    one: str
    other: str
    steps: SeedMean
    returns: SeedMean
    discordant: SeedMean
    told_apart: SeedMean
    each: tuple[Apart, ...]
    rescaling: Rescaling | None = None
    largest: "tuple[StepApart, ...]" = ()

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "rewards": [self.one, self.other],
            "steps": mean_json(self.steps),
            "returns": mean_json(self.returns),
            "discordant": mean_json(self.discordant),
            "told_apart": mean_json(self.told_apart),
            "rescaled": self.rescaling and self.rescaling.to_json(),
            "each": [{"steps": it.steps, "returns": it.returns, "discordant": it.order.discordant} for it in self.each],
            "largest": [step.to_json() for step in self.largest],
        }


def pair_of(
    one: str, other: str, each: Sequence[Apart], lines: Sequence[Line | None], largest: "Sequence[StepApart]" = ()
) -> Pair:
    """The means, with intervals over recordings or measurements.

    Args:
        one: A reward.
        other: Another one.
        each: How far apart they are, by recording or measurement.
        lines: The line of what they paid, in the same order.
        largest: See `Pair`.
    """
    return Pair(
        one,
        other,
        mean_within([it.steps for it in each]),
        mean_within([it.returns for it in each]),
        mean_within([it.order.discordant for it in each]),
        mean_within([it.order.told_apart for it in each]),
        tuple(each),
        rescaling_of(lines),
        tuple(largest),
    )


def mean_within(values: Sequence[float | None]) -> SeedMean:
    """The mean of numbers in [0, 1], its interval cut to that range; numbers that are None are left out."""
    return mean_over_seeds([value for value in values if value is not None], bounds=SHARE)


def mean_json(mean: SeedMean) -> dict[str, Any]:
    """Plain data; what the mean is over is no seed."""
    return {"mean": mean.mean, "low": mean.low, "high": mean.high, "count": mean.seeds}
