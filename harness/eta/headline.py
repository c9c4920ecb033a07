"""The answers of a comparison: first about the robot, then about the number, one sentence each.

A word of better or worse stands here only where a test says so whose error rate is known; see ``docs/statistics.md``.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, NamedTuple

from harness.eta.behaviour_change import Change
from harness.eta.index import Ratio
from harness.eta.power import Range, seeds_to_tell
from harness.eta.return_split import ReturnSplit
from harness.eta.seed_mean import SeedMean
from harness.eta.splits import Split, Splits
from harness.eta.swaps import ALPHA, fewest_seeds

SUCCESS, TIME = "success_rate", "time_to_target"
DECIDING = (SUCCESS, TIME)
"""Measures that decide about the robot. The first that tells the two trainings apart decides. Both count failures."""
SHORT = {SUCCESS: "success", TIME: "the time"}
"""Names of these measures for sentences about their margins."""
UNMEASURED = (
    "How the robot behaves was not measured, and rewards alone cannot tell whether it behaves better: name a measure "
    "of it, such as success."
)
SUCCESS_MARGIN = 0.05
"""A difference of success below this, as a share of the episodes, counts as none."""
TIME_MARGIN = 0.10
"""A difference of the time to the target below this, as a share of the baseline's, counts as none."""


class Answer(StrEnum):
    """Whether the proposed reward makes the robot behave better."""

    HELPS = "helps"
    HURTS = "hurts"
    NO_DIFFERENCE = "no difference"
    CANNOT_TELL = "cannot tell"


class Names(NamedTuple):
    """Labels of the two rewards."""

    baseline: str
    proposed: str


@dataclass(frozen=True)
class Headline:
    """Two answers: about the robot, and about the number.

    Attributes:
        answer: The answer about the robot.
        robot: This answer in a sentence.
        number: How much the indices changed, and how much of that is ruler, in a sentence.
        decided_by: The measure that decided; None if no measure did.
        seeds_to_decide: How many seeds would tell a difference as large as the margin, as a range; None where the
            robot's answer needs no more, or no number can be told.
    """

    answer: Answer
    robot: str
    number: str
    decided_by: str | None = None
    seeds_to_decide: Range | None = None

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "answer": self.answer.value,
            "behaviour": self.robot,
            "number": self.number,
            "decided_by": self.decided_by,
            "seeds_to_decide": self.seeds_to_decide and list(self.seeds_to_decide),
        }


def judge(
    names: Names,
    deciding: Sequence[Change],
    number: str,
    claims: int = 1,
    unmeasured: str = UNMEASURED,
) -> Headline:
    """Both answers from measures that may decide. The first that tells the two trainings apart decides.

    Args:
        names: The names of the rewards.
        deciding: Measures of behaviour of one manner, each of one seed at least.
        number: The sentence about the number.
        claims: How many are made together with these, for the number of seeds that would decide.
        unmeasured: The sentence for the case that there is no measure.
    """
    if not deciding:
        return Headline(Answer.CANNOT_TELL, unmeasured, number)
    decisive = next((change for change in deciding if change.direction), None)
    if decisive is not None:
        answer = Answer.HELPS if decisive.direction == "better" else Answer.HURTS
        return Headline(answer, _decided(names, decisive), number, decisive.name)
    if all(change.is_within(margin_of(change)) for change in deciding):
        return Headline(Answer.NO_DIFFERENCE, _no_difference(names, deciding), number)
    needed = _seeds_needed(deciding, claims)
    return Headline(Answer.CANNOT_TELL, _undecided(names, deciding, needed), number, seeds_to_decide=needed)


def margin_of(change: Change) -> float:
    """The margin of a measure, in its unit. A smaller difference counts as none."""
    if _is_share(change):
        return SUCCESS_MARGIN
    return TIME_MARGIN * abs(change.baseline or 0.0)


def number_sentence(names: Names, splits: Splits) -> str:
    """A sentence on how much each index changed, and how much of that is ruler and behaviour."""
    told = [_ratio_sentence(name, name.replace("eta", "I"), names, split) for name, split in splits.items()]
    return " ".join([*told, *(f"{name}: {flag}." for name, split in splits.items() for flag in split.flags)])


def return_sentence(names: Names, split: ReturnSplit) -> str:
    """The same for the mean return of an episode: as a ratio if there is one, else as a difference."""
    eta = split.ratio.eta
    if eta.value is not None and eta.near_zero is None:
        told = _ratio_sentence("The ratio of mean returns", "The mean return", names, split.ratio)
        return " ".join([told, *(f"The ratio: {flag}." for flag in split.ratio.flags)])
    change, ruler, behaviour = (_mean_text(it) for it in (split.total.change, split.total.ruler, split.total.behaviour))
    told = f"The mean return with {names.proposed} minus that with {names.baseline} is {change}"
    if split.total.ruler.mean is None:
        return f"{told}; not split: {split.total.ruler.note}."
    return (
        f"{told}: {ruler} from counting the same runs differently (ruler), {behaviour} from different runs (behaviour)."
    )


def count_seeds(seeds: int) -> str:
    """The number of seeds, in words."""
    return "1 seed" if seeds == 1 else f"{seeds} seeds"


def _amount_text(change: Change, value: float | None) -> str:
    """A value of a deciding measure, with its unit."""
    if value is None:
        return "n/a"
    return f"{value:.1%}" if _is_share(change) else f"{value:.3g} {change.measure.unit}".rstrip()


def _decided(names: Names, change: Change) -> str:
    verb = "helps" if change.direction == "better" else "hurts"
    corrected = change.corrected or 0.0
    p = "< 0.001" if corrected < 0.001 else f"{corrected:.3f}"
    return f"{names.proposed} {verb}: {_values(names, change)}; {count_seeds(change.seeds)}, corrected p {p}."


def _no_difference(names: Names, changes: Sequence[Change]) -> str:
    told = "; ".join(f"{_values(names, change)}, less than {_margin_text(change)} apart" for change in changes)
    tests = f"equivalence by two one-sided tests, {ALPHA:.0%} each"
    return f"{names.proposed} makes no difference that counts: {told} ({tests})."


def _undecided(names: Names, changes: Sequence[Change], needed: Range | None) -> str:
    seeds, fewest = changes[0].seeds, fewest_seeds()
    told = (
        f"Cannot tell from {count_seeds(seeds)} whether {names.proposed} helps or hurts: "
        f"{'; '.join(_values(names, change) for change in changes)}."
    )
    if needed is None:
        return f"{told} Fewer than {fewest} seeds cannot show anything." if seeds < fewest else told
    return (
        f"{told} {needed[0]} to {needed[1]} seeds would tell a difference of "
        f"{' or of '.join(map(_margin_text, changes))}."
    )


def _values(names: Names, change: Change) -> str:
    """The values of both rewards in words, and the interval of their difference."""
    told = (
        f"{change.name.replace('_', ' ')} {_amount_text(change, change.proposed)} with {names.proposed}, "
        f"{_amount_text(change, change.baseline)} with {names.baseline}"
    )
    if change.low is None or change.high is None:
        return told
    if _is_share(change):
        return f"{told} (difference {100 * change.low:+.1f} to {100 * change.high:+.1f} points)"
    unit = f" {change.measure.unit}" if change.measure.unit else ""
    return f"{told} (difference {change.low:+.3g} to {change.high:+.3g}{unit})"


def _is_share(change: Change) -> bool:
    """Whether a measure is written as a percentage."""
    return change.name == SUCCESS or change.measure.episodes is not None


def _margin_text(change: Change) -> str:
    name = SHORT.get(change.name, change.name.replace("_", " "))
    if _is_share(change):
        return f"{100 * SUCCESS_MARGIN:g} points of {name}"
    return f"{TIME_MARGIN:.0%} of {name}"


def _seeds_needed(changes: Sequence[Change], claims: int) -> Range | None:
    """The number of seeds with which every deciding measure would tell a difference as large as its margin."""
    ranges = [
        seeds_to_tell(margin_of(change), math.sqrt(change.variance), change.seeds, claims)
        for change in changes
        if change.variance is not None and margin_of(change) > 0.0
    ]
    known = [found for found in ranges if found is not None]
    if not known or len(known) < len(ranges):
        return None
    low, high = (max(ends) for ends in zip(*known, strict=True))
    return low, max(high, changes[0].seeds + 1)


def _ratio_sentence(name: str, amount: str, names: Names, split: Split) -> str:
    """A sentence on a ratio, with its name, and on the amount that it is a ratio of."""
    eta = split.eta
    if eta.value is None:
        return f"{name} n/a: {eta.note}."
    if eta.near_zero is not None:
        return f"{name} says little: {eta.near_zero}."
    told = f"{amount} with {names.proposed} is {_text(eta)} times that with {names.baseline}"
    if split.ruler.value is None or split.ruler.near_zero is not None:
        return f"{told}; not split: {split.ruler.near_zero or split.ruler.note}."
    return (
        f"{told}: x {_text(split.ruler)} from counting the same runs differently (ruler), "
        f"x {_text(split.behaviour)} from different runs (behaviour)."
    )


def _text(ratio: Ratio) -> str:
    told = f"{ratio.value:.3g}"
    if ratio.low is None or ratio.high is None:
        return told
    return f"{told} [{ratio.low:.3g}, {ratio.high:.3g}]"


def _mean_text(mean: SeedMean) -> str:
    if mean.mean is None:
        return "n/a"
    told = _digits(mean.mean, "+")
    return told if mean.low is None or mean.high is None else f"{told} [{_digits(mean.low)}, {_digits(mean.high)}]"


def _digits(value: float, sign: str = "") -> str:
    """A number with three digits, without an exponent up to a million."""
    return f"{float(f'{value:.3g}'):{sign},.6g}"
