"""The difference of a measure of behaviour under two rewards, and how far it can be trusted."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from harness.arrays import Float
from harness.eta.interval import (
    CONFIDENCE,
    ONE_SIDED,
    SHARE,
    UNBOUNDED,
    Bounds,
    Interval,
    cut_to,
    of_difference,
    why_no_interval,
)
from harness.eta.manner import TRAINING, WHOLE
from harness.eta.swaps import ALPHA, Swaps, p_of
from harness.eta.verdict.question import BOTH, LEAST_SEEDS, Question
from harness.files.plain import Plain, tells

NO_WORD = 0.0
"""The level of an experiment that is not trained to its end: no p is so small."""
FAILED = 0.5
"""A training failed if its policy succeeds in less than this share of its episodes."""


@tells("name", "unit", "better", "manner", "episodes", "title")
class Quantity(NamedTuple):
    """A measure of behaviour."""

    name: str
    """The name of the metric."""
    unit: str
    """The unit of its values; empty if it has none."""
    better: str
    """``higher`` or ``lower``; empty where nobody said it: then numbers are shown, and no word."""
    manner: str
    """How the policies acted, or when: ``deterministic``, ``stochastic``, ``while training``, ``while learning``."""
    episodes: int | None = None
    """How many episodes it is a share of; None if it is not a share."""
    title: str = ""
    """The name for readers; if empty, they see the name with blanks."""
    bounds: Bounds = UNBOUNDED
    """What a value can be, if the measure is no share."""

    @property
    def is_share(self) -> bool:
        """Whether it is a share of episodes, or a mean over them of something between 0 and 1."""
        return self.episodes is not None or self.bounds == SHARE

    @property
    def is_while_training(self) -> bool:
        """Whether it tells how a training went, and so how fast the policy learned, and not how it ended."""
        return self.manner in (TRAINING, WHOLE)

    @property
    def ends(self) -> Bounds:
        """What a value can be."""
        return self.bounds if self.episodes is None else SHARE

    @property
    def has_ends(self) -> bool:
        """Whether it is known how good and how bad a value can be. Without, no plain word is said of it."""
        return all(map(math.isfinite, self.ends))

    def count_failed(
        self, baseline: Sequence[float] | Float, proposed: Sequence[float] | Float
    ) -> tuple[int, int] | None:
        """How many trainings of each reward failed: less than half of their episodes succeed.

        None of no share of episodes, and of one such as collisions, of which less than half is no failure.
        """
        if self.episodes is None or self.better != "higher":
            return None
        ours, theirs = (int(np.less(values, FAILED).sum()) for values in (baseline, proposed))
        return ours, theirs


Values = Mapping[int, float]
"""A value of each training, by seed."""
Sides = tuple[Values, Values]
"""The values of the baseline's trainings, and of the proposed reward's; not paired, and not as many everywhere."""


@tells(
    "*measure",
    "baseline",
    "proposed",
    "random",
    "seeds",
    "difference",
    "low",
    "high",
    "p",
    "p_corrected=corrected",
    "result=direction",
    "interquartile_means=middles",
    "probability_of_improvement=improvement",
    "failed",
    "reason",
)
@dataclass(frozen=True)
class Change(Plain):
    """Means over trainings of one measure, which does not depend on any reward; see `together` for those over places.

    Attributes:
        measure: What is measured.
        baseline: Mean over the baseline's trainings; None if the metric is not defined.
        proposed: The same under the proposed reward.
        random: The same for random actions.
        trainings: The value of each training that has one, by seed.
        lost: The seeds of those that were begun and have none.
        low: Lower end of the 95 % interval of proposed - baseline, cut to what that can be; None where there is none.
        high: Upper end.
        likely: Ends of proposed - baseline, each passed in 5 % of the cases at most, also where trainings fail that
            were not seen; see `harness.eta.interval`. None where there are none.
        most: What the mean under each reward lies below in 95 %, reckoned likewise; None where it is not known.
        p: The p-value for no difference: of a measure that decides that of the verdict, else by an exact test over
            swapped seeds; None if it cannot be computed.
        corrected: The p-value corrected for all claims that are made together.
        spread: The standard deviation of one training; None below two trainings of each reward.
        outcomes: The mean difference with the trainings' names swapped in all ways, see `harness.eta.swaps`; None
            below two seeds that both rewards have, which can claim nothing.
        reason: Why the metric failed for a seed; empty if it did not fail, also if it is not defined.
        level: A corrected p-value up to this says that there is a difference; `NO_WORD` where nothing may be said.
        is_plain: Of a measure that decides: whether its bound leaves out 0. None of any other.
        of_places: The changes whose means over places it holds, in their own units; empty in a single place.
        of_mean: What a mean over places can be; None in a single place.
        is_of_size: Whether values are shares of the mean size in their place, since they have either sign.
    """

    measure: Quantity
    baseline: float | None
    proposed: float | None
    random: float | None
    trainings: Sides = field(default=({}, {}), repr=False)
    lost: tuple[tuple[int, ...], tuple[int, ...]] = ((), ())
    low: float | None = None
    high: float | None = None
    likely: Interval | None = field(default=None, repr=False)
    most: tuple[float, float] | None = field(default=None, repr=False)
    p: float | None = None
    corrected: float | None = None
    spread: float | None = field(default=None, repr=False)
    outcomes: Float | None = field(default=None, repr=False, compare=False)
    reason: str = ""
    level: float = field(default=ALPHA, repr=False)
    is_plain: bool | None = field(default=None, repr=False)
    of_places: tuple["Change", ...] = field(default=(), repr=False)
    of_mean: Bounds | None = field(default=None, repr=False)
    is_of_size: bool = False

    @property
    def name(self) -> str:
        """The name of the metric."""
        return self.measure.name

    @property
    def ends(self) -> Bounds:
        """What a value can be."""
        return self.of_mean or self.measure.ends

    @property
    def is_relative(self) -> bool:
        """Whether values are shares of the baseline's mean, or of a size, and not in the measure's unit."""
        return bool(self.of_places) and not self.measure.is_share

    @property
    def parts(self) -> tuple["Change", ...]:
        """What it holds of each place."""
        return self.of_places or (self,)

    @property
    def counts(self) -> tuple[int, int]:
        """How many trainings of each reward have a value, in all places."""
        ours, theirs = (sum(len(it.trainings[side]) for it in self.parts) for side in BOTH)
        return ours, theirs

    @property
    def without(self) -> tuple[int, int]:
        """How many trainings of each reward were begun and have no value, in all places."""
        ours, theirs = (sum(len(it.lost[side]) for it in self.parts) for side in BOTH)
        return ours, theirs

    @property
    def seeds(self) -> int:
        """How many trainings the reward has that has fewer, where it has the fewest."""
        return min(len(side) for it in self.parts for side in it.trainings)

    @property
    def can_decide(self) -> bool:
        """Whether every training has a value, or counts at an end that is known; and each reward has one."""
        return bool(self.seeds and self.measure.better) and (self.measure.has_ends or not any(self.without))

    @property
    def values(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """The values of the baseline's trainings, and of the proposed reward's, in all places."""
        ours, theirs = (tuple(value for it in self.parts for value in it.trainings[side].values()) for side in BOTH)
        return ours, theirs

    @property
    def size(self) -> float:
        """The mean absolute value over all trainings; whose they are plays no role."""
        one, other = self.values
        return float(np.mean(np.abs([*one, *other])))

    @property
    def difference(self) -> float | None:
        """Proposed - baseline, of the means."""
        return None if self.baseline is None or self.proposed is None else self.proposed - self.baseline

    @property
    def direction(self) -> str:
        """``better`` or ``worse`` where that is certain, and somebody said which is better; else empty.

        A hint is certain where its corrected p is small and its interval leaves out 0.
        """
        is_beyond = self.low is None or self.high is None or self.low > 0.0 or self.high < 0.0
        is_hint = self.corrected is not None and self.corrected <= self.level and is_beyond
        if not self.measure.better or not self.difference or not (is_hint if self.is_plain is None else self.is_plain):
            return ""
        return "better" if (self.difference > 0.0) == (self.measure.better == "higher") else "worse"

    @property
    def failed(self) -> tuple[int, int] | None:
        """How many trainings of each reward failed or left no value; None of other measures, see `count_failed`."""
        failed = self.measure.count_failed(*self.values)
        return failed and (failed[0] + self.without[0], failed[1] + self.without[1])

    @property
    def middles(self) -> tuple[float | None, float | None]:
        """Interquartile means over the trainings of the baseline, and of the proposed reward."""
        one, other = self.values
        return interquartile_mean(one), interquartile_mean(other)

    @property
    def improvement(self) -> float | None:
        """Chance that a run of the proposed reward is better than one of the baseline."""
        return probability_of_improvement(*self.values, self.measure.better)

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            **super().to_json(),
            "left_out": sum(self.without),
            "trainings": {
                side: {str(seed): value for seed, value in values.items()}
                for side, values in zip(("baseline", "proposed"), self.trainings, strict=True)
            },
        }


def change_of(
    measure: Quantity,
    baseline: Mapping[int, float | None],
    proposed: Mapping[int, float | None],
    swaps: Swaps,
    random: Sequence[float | None] = (),
) -> Change:
    """The change of one measure.

    Args:
        measure: What is measured.
        baseline: Its value for each training under the baseline, by seed; None if the metric is not defined.
        proposed: The same under the proposed reward.
        swaps: The ways in which the names of a seed's trainings are swapped.
        random: Its values for random actions.
    """
    one, other = ({seed: value for seed, value in side.items() if value is not None} for side in (baseline, proposed))
    lost = (tuple(baseline.keys() - one.keys()), tuple(proposed.keys() - other.keys()))
    found = Change(measure, _mean(one.values()), _mean(other.values()), _mean(random), (one, other), lost)
    if not found.seeds:
        return found
    both = [seed for seed in one if seed in other]
    if len(both) > 1:
        outcomes = swaps.of(both) @ np.array([other[seed] - one[seed] for seed in both]) / len(both)
        found = replace(found, outcomes=outcomes, p=p_of(outcomes))
    return with_intervals(found)


def with_intervals(change: Change, confidence: float = CONFIDENCE) -> Change:
    """The change in one place with what follows from its trainings' values: its spread, and its intervals.

    Args:
        change: The change.
        confidence: That of the interval that is printed; see `Question.bounds`.
    """
    if change.seeds < LEAST_SEEDS:
        return change
    one, other = (float(np.var(values, ddof=1)) for values in change.values)
    return _with_bounds(replace(change, spread=math.sqrt((one + other) / 2.0)), question_of([[change]]), confidence)


def together(changes: Sequence[Change], confidence: float = CONFIDENCE) -> Change:
    """Means over places of one measure.

    A measure that is no share counts relative to its mean size in each place, under both rewards together. Seconds of
    a slow place would outweigh those of a quick one, and the test does not weigh them either. Then the baseline's mean
    over places is taken for 1, so that readers meet the change that they would compute. It has the sign of what was
    tested, and lies between the changes of the single places. Values of either sign have no such mean, and stay shares
    of their size.

    Args:
        changes: Of one measure, one for each place.
        confidence: That of the interval.
    """
    measure, alone = changes[0].measure, [[change] for change in changes]
    scales = np.array([[1.0 / size_of(change)] for change in changes])
    question, is_of_size = question_of(alone, scales), False
    if not measure.is_share:
        base, known = abs(question.means[0]), question.values[question.known]
        is_of_size = not (base > 0.0 and (known.min() >= 0.0 or known.max() <= 0.0))
        question = question if is_of_size else question_of(alone, scales / base)
    low, high = map(float, question.ends[:, 0].mean(axis=0))
    found = Change(measure, *question.means, None, of_places=tuple(changes), of_mean=(low, high), is_of_size=is_of_size)
    if found.seeds < LEAST_SEEDS:
        return found
    spread = question.error(0) * math.sqrt(found.seeds / 2.0)
    return _with_bounds(replace(found, spread=spread), question, confidence)


def _with_bounds(change: Change, question: Question, confidence: float) -> Change:
    """The change with the intervals of its values."""
    low, high = question.bounds(0, confidence)
    if why_no_interval(change.seeds) or not math.isfinite(low):
        return change  # of too few, or how bad those may be that left no value is not known
    low, high = cut_to((low, high), of_difference(change.ends))
    if change.is_relative and not change.is_of_size:  # what never has the other sign loses all of it at most
        low = max(low, -1.0) if change.ends[0] >= 0.0 else low
        high = min(high, 1.0) if change.ends[1] <= 0.0 else high
    found = replace(change, low=low, high=high)
    return (
        replace(found, likely=question.bounds(0, ONE_SIDED), most=question.most(0)) if question.has_ends(0) else found
    )


def size_of(change: Change) -> float:
    """What values are divided by, so that places can be put together: 1 of a share, else the mean size."""
    return 1.0 if change.measure.is_share else change.size or 1.0


def seeds_of(changes: Sequence[Sequence[Change]]) -> list[int]:
    """All seeds of the trainings of changes, by place and measure, in order."""
    all_sides = (side for of_place in changes for change in of_place for side in (*change.trainings, *change.lost))
    return sorted({seed for side in all_sides for seed in side})


def question_of(changes: Sequence[Sequence[Change]], scales: Sequence[Sequence[float]] | Float = ((1.0,),)) -> Question:
    """A question about the values of changes.

    Args:
        changes: By place and measure.
        scales: What the values of each are multiplied by.
    """
    seeds = seeds_of(changes)
    row = {seed: at for at, seed in enumerate(seeds)}
    values = np.full((2, len(seeds), len(changes), len(changes[0])), np.nan)
    begun = np.zeros((2, len(seeds), len(changes)), np.bool_)
    for place, of_place in enumerate(changes):
        for measure, change in enumerate(of_place):
            for side, of_side in enumerate(change.trainings):
                at = [row[seed] for seed in of_side]
                values[side, at, place, measure] = np.array(change.values[side]) * scales[place][measure]
                begun[side, [*at, *(row[seed] for seed in change.lost[side])], place] = True
    ends = np.array([[change.measure.ends for change in of_place] for of_place in changes])
    # A negative scale swaps ends.
    return Question.of(values, np.sort(ends * np.array(scales)[..., None], axis=2), begun)


def _mean(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None


def interquartile_mean(values: Sequence[float]) -> float | None:
    """Mean of the middle half; None for fewer than 4 values, from which no quarter can be left out."""
    count = len(values)
    if count < 4:
        return None
    out = count // 4
    # As scipy.stats.trim_mean, down to the order of the additions; that takes a second to import.
    ordered = np.partition(np.asarray(values, np.float64), (out, count - out - 1))
    return float(np.mean(ordered[out : count - out]))


def probability_of_improvement(baseline: Sequence[float], proposed: Sequence[float], better: str) -> float | None:
    """Chance that a run of the proposed reward is better than one of the baseline, any against any; ties count half.

    0.5 where neither is better. The Mann-Whitney U over the number of pairs; None without a value on both sides, and
    where `better` is empty.
    """
    if not better or not len(baseline) or not len(proposed):
        return None
    gains = np.subtract.outer(np.asarray(proposed), np.asarray(baseline))
    share = float(np.mean(gains > 0.0) + 0.5 * np.mean(gains == 0.0))
    return share if better == "higher" else 1.0 - share


def performance_profile(values: Sequence[float], at: Sequence[float] | Float) -> Float:
    """Share of the runs with at least the values `at`, (len(at),). A profile above another one everywhere is better."""
    reached: Float = (np.asarray(values)[None, :] >= np.asarray(at)[:, None]).mean(axis=1)
    return reached
