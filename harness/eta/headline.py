"""The answer about the robot, one sentence or two.

A word of better or worse stands here only where a test says so whose error rate is known; see ``docs/statistics.md``.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, NamedTuple, Protocol

from harness.eta.behaviour_change import Measure
from harness.eta.interval import Interval
from harness.eta.power import Range, fewest_seeds, seeds_to_tell
from harness.eta.verdict.ruling import Ruling

SUCCESS, TIME = "success_rate", "time_to_target"
DECIDING = (SUCCESS, TIME)
"""Measures that decide about the robot, together: the answer rests on the one that says most. Both count failures."""
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
LEARNED = 0.10
"""Where both rewards teach success in less than this share of the episodes, neither teaches the task."""
PLANNABLE = 10
"""A number of seeds that is known only to a larger factor is no plan."""


class Answer(StrEnum):
    """Whether the proposed reward makes the robot behave better."""

    HELPS = "helps"
    HURTS = "hurts"
    LEARNS_FASTER = "learns faster"
    LEARNS_SLOWER = "learns slower"
    """Success while training decides alone; at the end no difference was found."""
    MIXED = "mixed"
    """Better in one place or by one measure, and worse in another, both by more than chance."""
    NO_DIFFERENCE = "no difference"
    NEITHER_LEARNS = "neither learns"
    CANNOT_TELL = "cannot tell"
    INTERIM = "interim"
    """Trainings of the plan are still to come, and no plan of looks says what may be concluded before."""
    RACED = "the race decides"
    """In a race for the best of several rewards no comparison with the baseline is a test."""


class Names(NamedTuple):
    """Labels of the two rewards."""

    baseline: str
    proposed: str


class Compared(Protocol):
    """Values of a measure under two rewards: in one place, or means over several."""

    @property
    def measure(self) -> Measure:
        """What is measured."""

    @property
    def name(self) -> str:
        """Its name."""

    @property
    def baseline(self) -> float | None:
        """The mean under the baseline."""

    @property
    def proposed(self) -> float | None:
        """The mean under the proposed reward."""

    @property
    def counts(self) -> tuple[int, int]:
        """How many trainings of the baseline and of the proposed reward are compared, over all places."""

    @property
    def seeds(self) -> int:
        """How many trainings each reward has in each place, at least."""

    @property
    def failed(self) -> tuple[int, int] | None:
        """How many of `counts` failed, of a share of which more is better; None of other measures."""

    @property
    def low(self) -> float | None:
        """The lower end of the 95 % interval of the difference."""

    @property
    def high(self) -> float | None:
        """The upper end."""

    @property
    def likely(self) -> Interval | None:
        """Ends of the difference that each hold in 95 %, also where trainings fail that were not seen."""

    @property
    def most(self) -> tuple[float, float] | None:
        """What the mean under each reward lies below in 95 %, reckoned likewise."""

    @property
    def spread(self) -> float | None:
        """The standard deviation of one training, as far as it counts for the mean; None if it is not known."""


@dataclass(frozen=True)
class Headline:
    """Two answers: about the robot, and about the number.

    Attributes:
        answer: The answer about the robot.
        robot: This answer in a sentence.
        number: How much the indices changed, and how much of that is ruler, in a sentence.
        decided_by: The measure that decided; None if no measure did.
        seeds_to_decide: How many seeds would tell the difference that was seen, as a range; None where the robot's
            answer needs no more, or no number can be told.
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
    deciding: Sequence[Compared],
    number: str,
    ruling: Ruling | None = None,
    unmeasured: str = UNMEASURED,
    where: str = "",
    *,
    same_steps: bool = False,
) -> Headline:
    """Both answers from the measures that decide.

    Args:
        names: The names of the rewards.
        deciding: Measures of behaviour of one manner, each of one seed at least.
        number: The sentence about the number.
        ruling: What the test says of them; its measures are these, in their order.
        unmeasured: The sentence for the case that there is no measure.
        where: Where this is so, in words, such as ``over 8 places``; empty for a single place.
        same_steps: Whether the policies of both rewards take the same steps, bit for bit: then no test is needed.
    """
    ruling = ruling or Ruling()
    if not deciding:
        return Headline(Answer.CANNOT_TELL, unmeasured, number)
    if ruling.instead:
        values = "; ".join(_values(names, change) for change in deciding)
        return Headline(Answer.RACED, f"{ruling.instead} {names.proposed}: {values}.", number)
    if ruling.is_decided:
        answer = Answer.HELPS if ruling.sign > 0 else Answer.HURTS
        told = _decided(names, deciding, ruling, where)
        return Headline(answer, told, number, deciding[ruling.decider].name)
    equal = _equal(names, deciding, number, ruling, where)
    if same_steps and (equal is None or equal.answer is not Answer.NEITHER_LEARNS):
        return Headline(Answer.NO_DIFFERENCE, _same(names, deciding), number)
    return equal or _cannot_tell(names, deciding, number, ruling, where)


def _equal(names: Names, deciding: Sequence[Compared], number: str, ruling: Ruling, where: str) -> Headline | None:
    """The answer that there is nothing to tell apart, where a test says so."""
    if _neither_learns(deciding[0]):
        return Headline(Answer.NEITHER_LEARNS, _too_little(names, deciding[0], where), number)
    if ruling.small is not None:
        return Headline(Answer.NO_DIFFERENCE, _small(names, deciding[0], ruling.small, where), number)
    if all(is_within(change, margin_of(change)) for change in deciding):
        return Headline(Answer.NO_DIFFERENCE, _no_difference(names, deciding, where), number)
    return None


def is_within(change: Compared, margin: float) -> bool:
    """Whether the difference is smaller than a margin, by two one-sided tests at 5 % (Schuirmann 1987)."""
    return change.likely is not None and -margin < change.likely[0] and change.likely[1] < margin


def margin_of(change: Compared) -> float:
    """The margin of a measure, in its unit. A smaller difference counts as none."""
    if is_share(change):
        return SUCCESS_MARGIN
    return TIME_MARGIN * abs(change.baseline or 0.0)


def count_seeds(seeds: int) -> str:
    """The number of seeds, in words."""
    return "1 seed" if seeds == 1 else f"{seeds} seeds"


def p_text(p: float | None) -> str:
    """A p-value in a sentence."""
    return "n/a" if p is None else "< 0.001" if p < 0.001 else f"{p:.3f}"


def _decided(names: Names, deciding: Sequence[Compared], ruling: Ruling, where: str) -> str:
    verb, change = "helps" if ruling.sign > 0 else "hurts", deciding[ruling.decider]
    told = (
        f"{names.proposed} {verb}{where and ' '}{where}: {_values(names, change)}; {count_seeds(change.seeds)}, "
        f"corrected p {p_text(ruling.corrected)}."
    )
    if not ruling.is_contrary:
        return told
    contrary = next(it for at, it in enumerate(deciding) if ruling.passes(at) and ruling.signs[at] != ruling.sign)
    return f"{told} But the opposite holds of another measure: {_values(names, contrary)}."


def _neither_learns(change: Compared) -> bool:
    return (
        is_share(change)
        and change.measure.better == "higher"
        and None not in (change.baseline, change.proposed)
        and max(change.baseline or 0.0, change.proposed or 0.0) < LEARNED
    )


def _too_little(names: Names, change: Compared, where: str) -> str:
    return (
        f"Neither {names.baseline} nor {names.proposed} teaches the task{where and ' '}{where}: "
        f"{_values(names, change)}. Success is below {LEARNED:.0%} under both, so there is no behaviour to compare. "
        "Train longer, or with another algorithm."
    )


def _same(names: Names, deciding: Sequence[Compared]) -> str:
    told = "; ".join(f"{it.name.replace('_', ' ')} {_amount_text(it, it.baseline)}" for it in deciding)
    return (
        f"{names.proposed} changes nothing: with {count_seeds(deciding[0].seeds)}, every step of every evaluation is "
        f"the same as with {names.baseline}, bit for bit; {told} with both."
    )


def _small(names: Names, change: Compared, margin: float, where: str) -> str:
    told = f"{100 * margin:g} points" if is_share(change) else f"{margin:.0%}"
    return (
        f"{names.proposed} differs by less than {told}{where and ' '}{where}: {_values(names, change)}; "
        f"{count_seeds(change.seeds)}. The training ended here, as planned: more seeds would not be worth their cost."
        f"{_unseen(change)}"
    )


def _no_difference(names: Names, changes: Sequence[Compared], where: str) -> str:
    told = "; ".join(f"{_values(names, change)}, less than {margin_text(change)} apart" for change in changes)
    return (
        f"{names.proposed} makes no difference that counts{where and ' '}{where}: {told} "
        f"(equivalence by two one-sided tests, 5% each).{_unseen(changes[0])}"
    )


def _unseen(change: Compared) -> str:
    """What the answer cannot see where no seed failed."""
    if not is_share(change) or change.lowest is None or change.lowest < FAILED:
        return ""
    return (
        f" No seed failed. But {count_seeds(change.seeds)} cannot rule out that up to "
        f"{min(1.0, 3.0 / change.seeds):.0%} of all trainings fail under either reward."
    )


def _cannot_tell(names: Names, deciding: Sequence[Compared], number: str, ruling: Ruling, where: str) -> Headline:
    seeds, fewest = deciding[0].seeds, fewest_seeds(ruling.level / (ruling.asked if where else 1))
    told = (
        f"Cannot tell from {count_seeds(seeds)}{where and ' '}{where} whether {names.proposed} helps or hurts: "
        f"{'; '.join(_values(names, change) for change in deciding)}."
    )
    if seeds < fewest and not ruling.has_plan:
        told = f"{told} Fewer than {fewest} seeds cannot show anything here."
    at_most = "; ".join(text for change in deciding if (text := _at_most(change)))
    lines = [told, f"The difference is at most {at_most} (90% interval)." if at_most else "", _yet(deciding, ruling)]
    seen, small = _seeds_needed(deciding, ruling, "seen"), _seeds_needed(deciding, ruling, "margin")
    margins = " or of ".join(map(margin_text, deciding))
    if seen:
        lines.append(_plan_text(seen, seeds, "the difference that was seen"))
    elif small:
        lines.append(_plan_text(small, seeds, f"a difference of {margins}"))
    robot = " ".join(line for line in lines if line)
    return Headline(Answer.CANNOT_TELL, robot, number, seeds_to_decide=seen or small)


def _plan_text(needed: Range, seeds: int, what: str) -> str:
    """How many seeds would tell a difference, unless so few seeds say next to nothing about that."""
    low, high = needed
    if high > PLANNABLE * low:
        return f"{count_seeds(seeds).capitalize()} are too few to plan how many would tell {what}."
    return f"{low:,} to {high:,} seeds would tell {what}."


def _at_most(change: Compared) -> str:
    if change.likely is None:
        return ""
    most = max(map(abs, change.likely))
    name = SHORT.get(change.name, change.name.replace("_", " "))
    if is_share(change):
        return f"{100 * most:.1f} points of {name}"
    return f"{most:.3g}{' ' if change.measure.unit else ''}{change.measure.unit} of {name}"


def _yet(deciding: Sequence[Compared], ruling: Ruling) -> str:
    """Why an interval that leaves out 0 is no answer."""
    out = [it for it in deciding if it.low is not None and it.high is not None and (it.low > 0.0 or it.high < 0.0)]
    if not out or ruling.corrected is None:
        return ""
    names = " and of ".join(SHORT.get(it.name, it.name.replace("_", " ")) for it in out)
    told = f"The interval of {names} leaves out 0 when it is looked at alone. But"
    p = p_text(ruling.corrected)
    if ruling.asked > 1:
        return f"{told} {ruling.asked} questions were asked together, and allowing for all of them p is {p}."
    return f"{told} the test allows for all deciding measures, and its p is {p}."


def _values(names: Names, change: Compared) -> str:
    """The values of both rewards in words, and the interval of their difference."""
    told = (
        f"{change.name.replace('_', ' ')} {_amount_text(change, change.proposed)} with {names.proposed}, "
        f"{_amount_text(change, change.baseline)} with {names.baseline}"
    )
    if change.low is None or change.high is None:
        return told
    if is_share(change):
        return f"{told} (difference {100 * change.low:+.1f} to {100 * change.high:+.1f} points)"
    unit = f" {change.measure.unit}" if change.measure.unit else ""
    return f"{told} (difference {change.low:+.3g} to {change.high:+.3g}{unit})"


def _amount_text(change: Compared, value: float | None) -> str:
    """A value of a deciding measure, with its unit."""
    if value is None:
        return "n/a"
    return f"{value:.1%}" if is_share(change) else f"{value:.3g} {change.measure.unit}".rstrip()


def is_share(change: Compared) -> bool:
    """Whether a measure is written as a percentage."""
    return change.name == SUCCESS or change.measure.episodes is not None


def margin_text(change: Compared) -> str:
    """The margin of a measure in words."""
    name = SHORT.get(change.name, change.name.replace("_", " "))
    if is_share(change):
        return f"{100 * SUCCESS_MARGIN:g} points of {name}"
    return f"{TIME_MARGIN:.0%} of {name}"


def _seeds_needed(changes: Sequence[Compared], ruling: Ruling, what: str) -> Range | None:
    """How many seeds would tell the difference that was seen, by the measure that shows it first; or the margins."""
    ranges = []
    for change in changes:
        apart = (change.proposed or 0.0) - (change.baseline or 0.0)
        size = abs(apart) if what == "seen" else margin_of(change)
        if change.spread is not None and size > 0.0 and math.isfinite(size):
            ranges.append(seeds_to_tell(size, change.spread, change.seeds, ruling.asked, ruling.level))
    known = [found for found in ranges if found is not None]
    if not known or (what == "margin" and len(known) < len(ranges)):
        return None
    low, high = min(known) if what == "seen" else tuple(max(ends) for ends in zip(*known, strict=True))
    seeds = changes[0].seeds
    return max(low, seeds + 1), max(high, seeds + 1)
