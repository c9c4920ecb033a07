"""The answer about the robot: the words there are, what they are said of, and what counts as a difference."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from math import comb, sqrt
from typing import Any, Protocol, TypeAlias

import numpy as np

from harness.arrays import Float
from harness.eta.behaviour_change import Change
from harness.eta.decomposition import OWNER, Splitter, noise_of_means, split_sum
from harness.eta.index import NEAR_ZERO, NOTHING, Estimate, mean_over_seeds
from harness.eta.interval import ROUNDING, quantile
from harness.eta.power import Range
from harness.eta.splits import BB, BK, KB, KK, Names, Pair, ScoredSums, Split, Splits, SumSplit, means_without_each
from harness.eta.swaps import Swaps, p_of
from harness.files.plain import Plain, tells

SUCCESS, TIME = "success_rate", "time_to_target"
DECIDING = (SUCCESS, TIME)
"""Measures that decide about the robot, together: the answer rests on the one that says most. Both count failures."""
SHORT = {SUCCESS: "success", TIME: "the time"}
"""Names of these measures for headings, and for sentences about their margins."""
UNMEASURED = (
    "How the robot behaves was not measured, and rewards alone cannot tell whether it behaves better: name a measure "
    "of it, such as success."
)
SUCCESS_MARGIN = 0.05
"""A difference of success below this, as a share of the episodes, counts as none."""
TIME_MARGIN = 0.10
"""A difference of any other measure below this, as a share of its mean size over both rewards, counts as none."""
LEARNED = 0.10
"""Where both rewards teach success in less than this share of the episodes, neither teaches the task."""


Text: TypeAlias = Callable[[float | None], str]
"""A function that writes a value as text."""


def percentage(value: float | None) -> str:
    """A share as a percentage."""
    return NOTHING if value is None else f"{value:.1%}"


def points(share: float | None) -> str:
    """A share in percentage points."""
    return f"{round(100 * (share or 0.0), 1) + 0.0:.1f}"  # no -0.0


class Bounded(Protocol):
    """A ratio, a mean or a difference with the ends of its interval."""

    @property
    def low(self) -> float | None:
        """The lower end; None where there is none."""

    @property
    def high(self) -> float | None:
        """The upper end."""


class Answer(StrEnum):
    """Whether the proposed reward makes the robot behave better."""

    HELPS = "helps"
    HURTS = "hurts"
    LEARNS_FASTER = "learns faster"
    LEARNS_SLOWER = "learns slower"
    """Success while training decides alone; the end is not told apart."""
    MIXED = "mixed"
    """Better in one place or by one measure, and worse in another, both by more than chance."""
    NO_DIFFERENCE = "no difference"
    NEITHER_LEARNS = "neither learns"
    AHEAD = "ahead so far"
    BEHIND = "behind so far"
    """These trainings differ by more than luck; whether new ones would is not known."""
    CANNOT_TELL = "cannot tell"
    INTERIM = "interim"
    """Trainings are missing, and no plan of looks says what may be concluded without them."""


@tells("answer=answer.value", "behaviour=robot", "number", "decided_by", "seeds_to_decide")
@dataclass(frozen=True)
class Headline(Plain):
    """Two answers: about the robot, and about the number.

    Attributes:
        answer: The answer about the robot.
        robot: This answer in a sentence.
        number: How much the indices changed, and how much of that is ruler, in a sentence.
        decided_by: The measure that decided, see `key_of`; None if no measure did.
        seeds_to_decide: How many trainings of each reward would tell, or show that nothing differs, as a range.
            None where the robot's answer needs no more, or no number can be told.
    """

    answer: Answer
    robot: str
    number: str
    decided_by: str | None = None
    seeds_to_decide: Range | None = None


def is_within(change: Change, margin: float) -> bool:
    """Whether the difference is smaller than a margin, by two one-sided tests at 5 % (Schuirmann 1987)."""
    return change.likely is not None and -margin < change.likely[0] and change.likely[1] < margin


def margin_of(change: Change) -> float:
    """The margin of a measure, in its unit. A smaller difference counts as none."""
    if is_share(change):
        return SUCCESS_MARGIN
    return TIME_MARGIN * (abs(change.baseline or 0.0) + abs(change.proposed or 0.0)) / 2.0


def margin_text(change: Change) -> str:
    """The margin of a measure in words."""
    size = size_text(change, SUCCESS_MARGIN if is_share(change) else TIME_MARGIN)
    return f"{size} of {_short_name(change)}{_while(change)}"


def size_text(change: Change, size: float) -> str:
    """A size of a difference in words: points of a share, else a part of the mean size."""
    return f"{100 * size:g} points" if is_share(change) else f"{size:.0%}"


def is_share(change: Change) -> bool:
    """Whether a measure is written as a percentage."""
    return change.measure.is_share and not change.measure.unit


def is_hardly_learned(change: Change) -> bool:
    """Whether success at the end is below `LEARNED` under both rewards, as far as it was seen."""
    if change.failed is None or change.measure.is_while_training:
        return False
    return max(change.baseline or 0.0, change.proposed or 0.0) < LEARNED


def reaches_of(change: Change) -> tuple[float, float]:
    """How far the mean of the reward that is ahead lies from the worst end, and the other one from the best end."""
    low, high = change.ends
    one, other = sorted((change.baseline or 0.0, change.proposed or 0.0))
    return (other - low, high - one) if change.measure.better == "higher" else (high - one, other - low)


def share_undone(change: Change) -> float | None:
    """Which share of trainings of the reward that is ahead would have to end as badly as they can to make both equal.

    None where it is not known how badly that is, or where nothing is ahead.
    """
    size, (reach, _) = abs(difference_of(change)), reaches_of(change)
    return size / reach if size > 0.0 and math.isfinite(reach) else None


def difference_of(change: Change) -> float:
    """Proposed - baseline, of the means."""
    return (change.proposed or 0.0) - (change.baseline or 0.0)


def name_of(change: Change) -> str:
    """The name of a measure in a sentence, such as ``success`` or ``success while training``."""
    told = "time to the target" if change.name == TIME else _short_name(change)
    return f"{told}{_while(change)}"


def name_with_article(change: Change) -> str:
    """The same within a sentence, with an article where it needs one, such as ``the time to the target``."""
    return f"the {name_of(change)}" if change.name == TIME else name_of(change)


def key_of(change: Change) -> str:
    """The name of a measure for a program, such as ``success_rate`` or ``success_rate while training``."""
    return f"{change.name}{_while(change)}"


def _short_name(change: Change) -> str:
    return SHORT.get(change.name) or change.measure.title or change.name.replace("_", " ")


def _while(change: Change) -> str:
    return f" {change.measure.manner}" if change.measure.is_while_training else ""


def count_seeds(seeds: int) -> str:
    """The number of seeds, in words."""
    return "1 seed" if seeds == 1 else f"{seeds} seeds"


def count_trainings(count: int) -> str:
    """The number of trainings, in words."""
    return "1 training" if count == 1 else f"{count} trainings"


def number_sentence(names: Names, splits: Splits) -> str:
    """A sentence on how much each index changed, and how much of that is ruler and behaviour."""
    told = [_ratio_sentence(name, name.replace("eta", "I"), names, split) for name, split in splits.items()]
    return " ".join([*told, *(f"{name}: {flag}." for name, split in splits.items() for flag in split.flags)])


def return_sentence(names: Names, split: "ReturnSplit") -> str:
    """The pay of an episode: its ratio if there is one, else its difference, and both parts, with their intervals."""
    proposed, baseline = (format_number(split.returns[pair].value) for pair in (KK, BB))
    told = f"An episode is paid {proposed} with {names.proposed} and {baseline} with {names.baseline}: "
    total, ratio, flags = split.total, split.ratio, ""
    if split.has_ratio:
        told, why = f"{told}{estimate_text(ratio.eta)} times as much", ratio.ruler.why
        parts = [f"x {estimate_text(it)}" for it in (ratio.ruler, ratio.behaviour) if it.is_telling]
        flags = "".join(f" The ratio: {flag}." for flag in ratio.flags)
    else:
        told, why = f"{told}a change of {estimate_text(total.change, signed)}", total.ruler.note
        parts = [estimate_text(it, signed) for it in (total.ruler, total.behaviour) if it.value is not None]
    if len(parts) < 2:
        return f"{told}. It cannot be split: {why}."
    return f"{told}. Rescaling alone (the ruler): {parts[0]}. Behaviour: {parts[1]}.{flags}"


def _ratio_sentence(name: str, amount: str, names: Names, split: Split) -> str:
    """A sentence on a ratio, with its name, and on the amount that it is a ratio of."""
    eta = split.eta
    if eta.value is None:
        return f"{name} n/a: {eta.note}."
    if eta.near_zero is not None:
        return f"{name} says little: {eta.near_zero}."
    told = f"{amount} with {names.proposed} is {estimate_text(eta)} times that with {names.baseline}"
    if not split.ruler.is_telling:
        return f"{told}; not split: {split.ruler.why}."
    return (
        f"{told}: x {estimate_text(split.ruler)} by rescaling alone (its ruler), "
        f"x {estimate_text(split.behaviour)} by other runs (its behaviour)."
    )


def signed(value: float | None) -> str:
    """A difference, with its sign."""
    return f"{'+' if value and value > 0.0 else ''}{format_number(value)}"


def format_number(value: float | None) -> str:
    """Three significant digits, without an exponent where that is readable."""
    if value is None:
        return NOTHING
    rounded = float(f"{value:.2e}") + 0.0  # no -0.0: an interval may end there
    size = math.floor(math.log10(abs(rounded))) if rounded else 0
    if not -4 <= size < 6:
        return f"{rounded:.2e}"
    return f"{rounded:,.{max(0, 2 - size)}f}"


def interval_text(of: Bounded, missing: str = NOTHING, text: Text = format_number) -> str:
    """The interval of a ratio that says something, of a mean or of a difference; `missing` where there is none."""
    says_little = isinstance(of, Estimate) and of.near_zero is not None
    if says_little or of.low is None or of.high is None:
        return missing
    return f"[{text(of.low)}, {text(of.high)}]"


def estimate_text(of: Estimate, text: Text = format_number) -> str:
    """The number, and its interval if there is one to show."""
    return f"{value_text(of, text)} {interval_text(of, '', text)}".rstrip()


def value_text(of: Estimate, text: Text = format_number) -> str:
    """The number alone, or the word in its place: a ratio says little if an index is near zero beside the other."""
    return text(of.value) if of.near_zero is None else NEAR_ZERO


def factor_text(ratio: Estimate) -> str:
    """A ratio as a factor, such as ``x 1.52``."""
    return f"x {value_text(ratio)}" if ratio.is_telling else NOTHING


def is_drawable(ratio: Estimate) -> bool:
    """Whether a ratio can be drawn: 0 has no logarithm, and a ratio that says little would stretch the axis."""
    return ratio.is_telling and (ratio.value or 0.0) > 0.0


LEVEL = 0.05
"""The chance of a wrong claim, at most."""
OF_RANDOM = 0.01
"""The part of it that is spent on the mean of random actions."""


@tells("reward", "trained", "random=at_random", "below", "p")
@dataclass(frozen=True)
class PaidAtRandom(Plain):
    """What a reward pays its own policies, and what it pays random actions in the same episodes.

    Attributes:
        reward: The label of the reward.
        trained: The mean return of an episode, of each training.
        at_random: The mean return of an episode of random actions.
        least: The mean of random actions lies above this, but for a chance of `OF_RANDOM`.
    """

    reward: str
    trained: tuple[float, ...]
    at_random: float
    least: float

    @property
    def below(self) -> int:
        """How many trainings are paid less than random actions, by more than rounding."""
        return sum(it < self.least - ROUNDING * abs(self.least) for it in self.trained)

    @property
    def p(self) -> float:
        """How often so many or more are below where a training is as likely above."""
        count = len(self.trained)
        return float(sum(comb(count, it) for it in range(self.below, count + 1)) / 2**count)

    @property
    def is_below(self) -> bool:
        """Whether most trainings are paid less than random actions, by more than chance."""
        return self.p <= LEVEL - OF_RANDOM

    @property
    def told(self) -> str:
        """The claim in words; empty where it cannot be made."""
        if not self.is_below:
            return ""
        count, mean = len(self.trained), float(np.mean(self.trained))
        below = f"all {count}" if self.below == count else f"{self.below} of {count}"
        return (
            f"{self.reward} was not maximised: it pays random actions more than the policies of {below} trainings "
            f"({_digits(self.at_random)} an episode; after training {_digits(mean)} on average). So this comparison "
            f"says nothing about what {self.reward} asks for. The test is made to err in at most {LEVEL:.0%} of cases."
        )


def paid_at_random(reward: str, trained: Sequence[float], episodes: Float) -> PaidAtRandom | None:
    """What a reward pays beside random actions; None without two episodes of these, or without a training.

    Args:
        reward: The label of the reward.
        trained: The mean return of an episode, of each training by this reward.
        episodes: The returns of random actions, (episodes,).
    """
    if len(episodes) < 2 or not trained:
        return None
    mean, error = float(episodes.mean()), float(episodes.std(ddof=1)) / sqrt(len(episodes))
    reach = quantile(1.0 - 2.0 * OF_RANDOM, len(episodes) - 1) * error
    return PaidAtRandom(reward, tuple(trained), mean, mean - reach)


def _digits(value: float) -> str:
    """A number with four digits, without an exponent up to a million."""
    return f"{float(f'{value:.4g}'):,.6g}"


NAME = "mean return"

Returns = Mapping[Pair, Sequence[float]]
"""R_r(q) of each seed by (r, q): the reward that scores, and the reward whose training is scored."""


@tells("returns=paid", "ratio", "difference=total")
@dataclass(frozen=True)
class ReturnSplit(Plain):
    """The mean return of two trainings.

    Attributes:
        returns: R_r(q) over seeds, by (r, q).
        ratio: eta = R_K(K) / R_B(B), and its parts; without a value if a return is not above 0.
        total: R_K(K) - R_B(B), and its parts.
    """

    returns: Mapping[Pair, Estimate]
    ratio: Split
    total: SumSplit

    @property
    def is_split(self) -> bool:
        """Whether each training was paid by the other's reward."""
        return {BK, KB} <= self.returns.keys()

    @property
    def has_ratio(self) -> bool:
        """Whether the ratio says something; where it does not, the difference is told."""
        return is_drawable(self.ratio.eta)

    def with_corrected(self, p: float | None) -> "ReturnSplit":
        """The same split with a p-value that holds for all claims that are made together."""
        return replace(self, ratio=replace(self.ratio, corrected=p))

    @property
    def paid(self) -> list[dict[str, Any]]:
        """The returns, each with the reward that pays and the reward whose training is paid."""
        return [
            {"paid_by": payer, "trained_by": trained, **mean.to_json()}
            for (payer, trained), mean in self.returns.items()
        ]


def split_returns(
    returns: Returns, seeds: Sequence[int], swaps: Swaps | None, missing: str | None = None
) -> ReturnSplit:
    """Both splits, with intervals over seeds.

    Args:
        returns: At least of (baseline, baseline) and (proposed, proposed), one finite value per seed.
        seeds: The seeds of the values; seed i of both trainings is a pair.
        swaps: The ways in which the names of a seed's trainings are swapped; None if no claim is made.
        missing: Why the other two are not there; None where they are.
    """
    each = {pair: np.asarray(values, np.float64) for pair, values in returns.items()}
    sums = ScoredSums(
        {pair: np.array([values.mean()]) for pair, values in each.items()},
        {pair: means_without_each(values) for pair, values in each.items()},
        each,
        paired=True,
    )
    is_claim = swaps is not None and len(seeds) > 1
    outcomes = swaps.of(seeds) @ (each[KK] - each[BB]) / len(seeds) if swaps and is_claim else None
    return ReturnSplit(
        {pair: mean_over_seeds(values.tolist()) for pair, values in each.items()},
        _split_ratio(sums, outcomes, missing),
        split_sum(sums, missing),
    )


def _split_ratio(sums: ScoredSums, outcomes: Float | None, missing: str | None) -> Split:
    small = next((pair for pair in sums.whole if sums.value(pair) <= 0.0), None)
    if small is not None:
        reason = f"the {NAME} of {OWNER[small]} is not above 0, and a ratio would say nothing: see the difference"
        nothing = Estimate(None, notes=(reason,))
        p = None if outcomes is None else p_of(outcomes)
        return Split(nothing, nothing, nothing, nothing, nothing, noise=nothing, p=p, outcomes=outcomes)
    split = Splitter(f"the {NAME}", _positive(sums)).split(outcomes, missing)
    return replace(split, noise=noise_of_means(sums.each[BB]))


def _positive(sums: ScoredSums) -> ScoredSums:
    """The sums with NaN for values that are not above 0. Two negative values would give a ratio like any other."""
    without = {pair: np.where(values > 0.0, values, np.nan) for pair, values in sums.without.items()}
    return replace(sums, without=without)
