"""The answer about the robot in whole sentences: what was seen first, then the word, then what would tell.

A word of better or worse stands here only where a test says so whose error rate is known; see ``docs/statistics.md``.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from harness.eta.amounts import listed, seen_text, trainings_text, unseen_text
from harness.eta.headline import (
    LEARNED,
    PLANNABLE,
    UNMEASURED,
    Answer,
    Compared,
    Headline,
    Names,
    difference_of,
    is_hardly_learned,
    is_share,
    is_within,
    key_of,
    margin_of,
    margin_text,
    name_of,
)
from harness.eta.power import Range, fewest_seeds, seeds_to_tell
from harness.eta.verdict.ruling import Ruling

TRAIN_LONGER = "Train longer, or with another algorithm."
UNTIL_DECIDED = "harness run --until decided plans for looks on the way."


class Needed(NamedTuple):
    """How many trainings of each reward would tell."""

    seeds: Range
    condition: str
    """What has to be so for that, in words."""


def judge(
    names: Names,
    deciding: Sequence[Compared],
    number: str,
    ruling: Ruling | None = None,
    unmeasured: str = UNMEASURED,
    where: str = "",
    *,
    same_steps: bool = False,
    is_opposed: bool = False,
) -> Headline:
    """Both answers from the measures that decide.

    Args:
        names: The names of the rewards.
        deciding: Measures of behaviour, of one training of each reward at least.
        number: The sentence about the number.
        ruling: What the test says of them; its measures are these, in their order.
        unmeasured: The sentence for the case that there is no measure.
        where: Where this is so, in words, such as ``over 8 places``; empty for a single place.
        same_steps: Whether the policies of both rewards take the same steps, bit for bit: then no test is needed.
        is_opposed: Whether it goes the other way in some of several places, by more than chance.
    """
    ruling = ruling or Ruling()
    if not deciding:
        return Headline(Answer.CANNOT_TELL, unmeasured, number)
    answer = answer_of(deciding, ruling, same_steps=same_steps, is_opposed=is_opposed)
    seen, there = seen_text(names, deciding, where), f" {where}" if where else ""
    if answer is Answer.RACED:
        return Headline(answer, f"{seen} {ruling.instead}", number)
    if answer is Answer.INTERIM:
        return Headline(answer, f"{interim_text(deciding, ruling)} {seen} {LOOK_ON}", number)
    if ruling.is_decided:
        decider = decider_of(deciding, ruling, answer)
        told = _decided(names, deciding, ruling, answer, there)
        lines = [seen, told, crossing_text(deciding, ruling, answer), clear_text(deciding, ruling)]
        return Headline(answer, " ".join(filter(None, lines)), number, key_of(deciding[decider]))
    if answer is Answer.CANNOT_TELL:
        needed = needed_of(deciding, ruling)
        lines = [seen, *_cannot_tell(names, deciding, ruling, needed, there)]
        return Headline(answer, " ".join(filter(None, lines)), number, seeds_to_decide=needed and needed.seeds)
    return Headline(answer, f"{seen} {_equal(names, deciding, ruling, answer, same_steps, there)}", number)


def answer_of(
    deciding: Sequence[Compared], ruling: Ruling, *, same_steps: bool = False, is_opposed: bool = False
) -> Answer:
    """The word for what the test says of at least one measure; see `judge`."""
    if ruling.instead:
        return Answer.RACED
    if ruling.missing:
        return Answer.INTERIM
    if ruling.is_decided:
        return _answer_of_decided(deciding, ruling, is_opposed)
    if _neither_learns(deciding[0]):
        return Answer.NEITHER_LEARNS
    if ruling.small is not None or same_steps or all(is_within(change, margin_of(change)) for change in deciding):
        return Answer.NO_DIFFERENCE
    return Answer.CANNOT_TELL


def _answer_of_decided(deciding: Sequence[Compared], ruling: Ruling, is_opposed: bool) -> Answer:
    if is_opposed or ruling.is_contrary:
        return Answer.MIXED
    is_better = ruling.sign > 0
    passing = [change for at, change in enumerate(deciding) if ruling.passes(at)]
    has_end = not all(change.measure.is_while_training for change in deciding)
    if has_end and all(change.measure.is_while_training for change in passing):
        return Answer.LEARNS_FASTER if is_better else Answer.LEARNS_SLOWER
    return Answer.HELPS if is_better else Answer.HURTS


def decider_of(deciding: Sequence[Compared], ruling: Ruling, answer: Answer) -> int:
    """Which measure an answer rests on: of those that it is about, the one with the smallest p."""
    passing = [at for at in range(len(deciding)) if ruling.passes(at)]
    if answer in (Answer.HELPS, Answer.HURTS):
        passing = [at for at in passing if not deciding[at].measure.is_while_training] or passing
    return min(passing, key=ruling.of_measures.__getitem__)


def is_little(deciding: Sequence[Compared], ruling: Ruling, answer: Answer) -> bool:
    """Whether the difference of the measure that decided, and of all others that pass, is smaller than its margin."""
    return answer is not Answer.MIXED and all(
        abs(difference_of(change)) < margin_of(change) for at, change in enumerate(deciding) if ruling.passes(at)
    )


def interim_text(deciding: Sequence[Compared], ruling: Ruling) -> str:
    """How many trainings there are, and how many are still to come."""
    done = sum(deciding[0].counts)
    return f"Interim: {done:,} trainings are compared, {ruling.missing:,} of the plan are still to come."


LOOK_ON = f"No test is made before they have ended; {UNTIL_DECIDED}"


def p_text(p: float | None) -> str:
    """A p-value in a sentence."""
    return "n/a" if p is None else "< 0.001" if p < 0.001 else f"{p:.3f}"


def crossing_text(deciding: Sequence[Compared], ruling: Ruling, answer: Answer) -> str:
    """Why a measure decided whose interval holds 0; empty where it does not."""
    change = deciding[decider_of(deciding, ruling, answer)]
    if change.low is None or change.high is None or not change.low <= 0.0 <= change.high:
        return ""
    if is_share(change):
        return "The interval holds 0 as it allows for failures that were not seen; p is of an exact test of what was."
    return "The interval holds 0 as it assumes a bell curve; p is of an exact test, which does not."


def clear_text(deciding: Sequence[Compared], ruling: Ruling) -> str:
    """Why an interval that leaves out 0 is no answer; empty where there is none of a measure that did not pass."""
    clear = [
        (it, ruling.of_measures[at])
        for at, it in enumerate(deciding)
        if at < len(ruling.of_measures) and not ruling.passes(at) and _leaves_out_zero(it)
    ]
    if not clear:
        return ""
    names, p = listed([name_of(it) for it, _ in clear]), " and ".join(p_text(p) for _, p in clear)
    told = f"The interval of {names} leaves out 0 when it is looked at alone, but"
    if ruling.asked > 1:
        return f"{told} {ruling.asked} questions were asked together, and allowing for all of them p is {p}."
    several = len(deciding) > 1
    return f"{told} {'allowing for all measures that decide' if several else 'by an exact test'} p is {p}."


def needed_of(deciding: Sequence[Compared], ruling: Ruling) -> Needed | None:
    """How many trainings of each reward would tell: the difference that was seen, else differences of the margins."""
    seen = _seeds_needed(deciding, ruling, "seen")
    if seen is not None:
        return Needed(seen, "the difference is what was seen so far")
    small = _seeds_needed(deciding, ruling, "margin")
    return None if small is None else Needed(small, f"it is {' or '.join(map(margin_text, deciding))}")


def needed_text(deciding: Sequence[Compared], needed: Needed | None, noun: str = "trainings of each reward") -> str:
    """The same in a sentence; empty where it is not known, or where more trainings of this kind are no help."""
    if needed is None or is_hardly_learned(deciding[0]):
        return ""
    if needed.seeds[1] > PLANNABLE * needed.seeds[0]:
        return "So few trainings do not tell how many would be enough."
    return f"If {needed.condition}, {range_text(needed.seeds)} {noun} would tell."


def reasons(names: Names, deciding: Sequence[Compared], ruling: Ruling) -> list[str]:
    """Why nothing can be told, a sentence each, where that needs saying."""
    looks_alike = all(abs(difference_of(it)) < margin_of(it) for it in deciding if is_share(it))
    floored = "p was raised, as no training of one reward failed: some may, that were not seen."
    lines = [
        floored if ruling.is_floored else "",
        clear_text(deciding, ruling),
        unseen_text(names, deciding) if looks_alike else "",
    ]
    return [line for line in lines if line]


def range_text(seeds: Range) -> str:
    """A range of whole numbers; of one number that number."""
    low, high = seeds
    return f"{low:,}" if low == high else f"{low:,} to {high:,}"


def allowance_text(deciding: Sequence[Compared]) -> str:
    """What an answer of no difference allows for."""
    return ", also where trainings fail that were not seen" if any(map(is_share, deciding)) else ""


def _decided(names: Names, deciding: Sequence[Compared], ruling: Ruling, answer: Answer, there: str) -> str:
    if answer is Answer.MIXED:
        return _mixed(names, deciding, ruling, there)
    at = decider_of(deciding, ruling, answer)
    by = f", decided by {name_of(deciding[at])}" if len(deciding) > 1 else ""
    p = f"corrected p {p_text(ruling.of_measures[at])}"
    little = is_little(deciding, ruling, answer)
    less = f": less than {margin_text(deciding[at])}" if little else ""
    if answer in (Answer.LEARNS_FASTER, Answer.LEARNS_SLOWER):
        word = f"{answer.value}{' by little' if little else ''}"
        return f"{names.proposed} {word}{there}{by}, {p}{less}; at the end no difference was found."
    speed = [(other, it) for other, it in enumerate(deciding) if it.measure.is_while_training and other != at]
    learns = "".join(
        f"; it also learns {'faster' if ruling.sign > 0 else 'more slowly'}, corrected p "
        f"{p_text(ruling.of_measures[other])}"
        for other, _ in speed
        if ruling.passes(other)
    )
    return f"{names.proposed} {answer.value}{' by little' if little else ''}{there}{by}, {p}{less}{learns}."


def _mixed(names: Names, deciding: Sequence[Compared], ruling: Ruling, there: str) -> str:
    """What is better and what is worse, each with its p."""
    sides = []
    for sign, word in ((1, "better"), (-1, "worse")):
        of_side = [at for at in range(len(deciding)) if ruling.passes(at) and ruling.signs[at] == sign]
        told = [f"{name_of(deciding[at])} (corrected p {p_text(ruling.of_measures[at])})" for at in of_side]
        sides += [f"{word} in {listed(told)}"] if told else []
    average = f" on average{there}" if there else ""
    return f"{names.proposed} is {' and '.join(sides)}{average}."


def _neither_learns(change: Compared) -> bool:
    return is_hardly_learned(change) and change.most is not None and max(change.most) < LEARNED


def _equal(
    names: Names, deciding: Sequence[Compared], ruling: Ruling, answer: Answer, same_steps: bool, there: str
) -> str:
    """That there is nothing to tell apart, and what says so."""
    if answer is Answer.NEITHER_LEARNS:
        return (
            f"Neither reward teaches the task{there}: success is certainly below {LEARNED:.0%} under both"
            f"{allowance_text(deciding)}. So there is no behaviour to compare. {TRAIN_LONGER}"
        )
    if ruling.small is None and same_steps:
        return (
            f"{names.proposed} changes nothing: every step of every evaluation is the same as with {names.baseline}, "
            f"bit for bit.{_advice(deciding)}"
        )
    reserve = unseen_text(names, deciding)
    told = [_small(names, deciding, ruling.small, there) if ruling.small else _no_difference(names, deciding, there)]
    return " ".join([*told, *([reserve] if reserve else [])])


def _small(names: Names, deciding: Sequence[Compared], margin: float, there: str) -> str:
    size = f"{100 * margin:g} points" if is_share(deciding[0]) else f"{margin:.0%}"
    alone = f" This is said of {name_of(deciding[0])} alone." if len(deciding) > 1 else ""
    return (
        f"The {name_of(deciding[0])} of {names.proposed} differs by less than {size}{there}"
        f"{allowance_text(deciding[:1])}. The training ended here, as planned: more would not be worth its cost.{alone}"
    )


def _no_difference(names: Names, deciding: Sequence[Compared], there: str) -> str:
    return (
        f"{names.proposed} makes no difference that counts{there}: less than "
        f"{listed([margin_text(change) for change in deciding])}{allowance_text(deciding)} (two one-sided tests for "
        "each, at 5%)."
    )


def _advice(deciding: Sequence[Compared]) -> str:
    return f" {TRAIN_LONGER}" if is_hardly_learned(deciding[0]) else ""


def _cannot_tell(
    names: Names, deciding: Sequence[Compared], ruling: Ruling, needed: Needed | None, there: str
) -> list[str]:
    """That it is not known, why, and what would help."""
    p = "" if ruling.corrected is None else f": corrected p {p_text(ruling.corrected)}"
    fewest = fewest_seeds(ruling.level / (ruling.asked if there else 1))
    too_few = max(deciding[0].counts) < fewest and not there and not ruling.has_plan
    return [
        f"Whether {names.proposed} helps or hurts{there} cannot be told from {trainings_text(names, deciding[0].counts)}"
        f"{p}.",
        f"Fewer than {fewest} of each cannot show anything." if too_few else "",
        *reasons(names, deciding, ruling),
        TRAIN_LONGER if is_hardly_learned(deciding[0]) else needed_text(deciding, needed),
    ]


def _leaves_out_zero(change: Compared) -> bool:
    return change.low is not None and change.high is not None and (change.low > 0.0 or change.high < 0.0)


def _seeds_needed(changes: Sequence[Compared], ruling: Ruling, what: str) -> Range | None:
    """How many seeds would tell the difference that was seen, by the measure that shows it first; or the margins."""
    ranges = []
    for change in changes:
        size = abs(difference_of(change)) if what == "seen" else margin_of(change)
        if change.spread is not None and size > 0.0 and math.isfinite(size):
            ranges.append(seeds_to_tell(size, change.spread, change.seeds, ruling.asked, ruling.level))
    known = [found for found in ranges if found is not None]
    if not known or (what == "margin" and len(known) < len(ranges)):
        return None
    low, high = min(known) if what == "seen" else tuple(max(ends) for ends in zip(*known, strict=True))
    seeds = changes[0].seeds
    return max(low, seeds + 1), max(high, seeds + 1)
