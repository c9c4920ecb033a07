"""The answer in a sentence or two, without a bracket: what a reader takes away who has seen the differences.

It says no more than the headline, from which it is made: a word of better or worse stands here only where the test of
the headline says so.
"""

from collections.abc import Sequence

from harness.eta.amounts import capitalised, listed, relative_text, short_values
from harness.eta.behaviour_change import Change
from harness.eta.headline import (
    TIME,
    Answer,
    Headline,
    is_hardly_learned,
    is_share,
    margin_text,
    name_of,
    name_with_article,
    size_text,
)
from harness.eta.judgement import (
    NO_TEST,
    TRAIN_LONGER,
    allowance_text,
    below_text,
    decider_of,
    end_text,
    is_little,
    is_same,
    progress_text,
)
from harness.eta.verdict.ruling import Ruling

INSTEAD = " instead of "


def lead_of(
    found: Headline,
    deciding: Sequence[Change],
    ruling: Ruling,
    subject: str,
    where: str = "",
    *,
    same_steps: bool = False,
) -> str:
    """The answer about the robot in a sentence or two.

    Args:
        found: The answer.
        deciding: Measures of behaviour that decide, as `harness.eta.judgement.judge` was given them.
        ruling: What the test says of them.
        subject: Who behaves: ``robot`` or ``agent``.
        where: Where this is so, in words, such as ``over 4 places``; empty for a single place.
        same_steps: Whether the policies of both rewards take the same steps, bit for bit.
    """
    if not deciding:
        return found.robot
    if found.answer is Answer.NEITHER_LEARNS:
        return _neither_learns(deciding, ruling, where)
    if found.answer is Answer.MIXED:
        return _sides(deciding, ruling, where)
    if ruling.is_decided or found.answer in (Answer.AHEAD, Answer.BEHIND):
        return _decided(found.answer, deciding, ruling, subject, where)
    if found.answer is Answer.NO_DIFFERENCE:
        return _no_difference(deciding, ruling, subject, where, same_steps)
    return _untold(found.answer, deciding, ruling, where)


def _untold(answer: Answer, deciding: Sequence[Change], ruling: Ruling, where: str) -> str:
    """Why the rewards are not compared, or not told apart."""
    if answer is Answer.INTERIM:
        return f"{progress_text(deciding, ruling)} {NO_TEST}"
    return TRAIN_LONGER if is_hardly_learned(deciding[0]) else _not_enough(deciding, where)


def _decided(answer: Answer, deciding: Sequence[Change], ruling: Ruling, subject: str, where: str) -> str:
    """What the robot does instead; then what else passed; then what did not, at the end of the trainings."""
    first = decider_of(deciding, ruling, answer)
    sign = ruling.sign * ruling.is_decided
    lines = [f"{_does(deciding[first], subject, sign)}{_there(where)}."]
    others = [(at, it) for at, it in enumerate(deciding) if at != first]
    lines += [f"{_does(it, subject, sign, 'also ')}." for at, it in others if ruling.passes(at)]
    if not ruling.is_decided:
        return f"In these trainings: {lines[0][0].lower()}{' '.join(lines)[1:]} New ones may not differ."
    if is_little(deciding, ruling, answer):
        lines.append(f"That is little: less than {margin_text(deciding[first])}.")
    ends = [it for at, it in others if not ruling.passes(at) and not it.measure.is_while_training]
    if answer in (Answer.LEARNS_FASTER, Answer.LEARNS_SLOWER):
        lines.append(f"{end_text(ends).capitalize()}.")
    elif ends:
        verb = "differs" if len(ends) == 1 else "differ"
        lines.append(f"Whether {listed([name_with_article(it) for it in ends])} {verb} too cannot be told.")
    return " ".join(lines)


def _neither_learns(deciding: Sequence[Change], ruling: Ruling, where: str) -> str:
    """The lead that says: both fail at the task; then what differs all the same."""
    lines = [f"Success is {below_text(deciding[0])}{_there(where)}."]
    if ruling.is_decided:
        lines.append(f"The two differ all the same. {_sides(deciding, ruling, where)}")
    return " ".join([*lines, TRAIN_LONGER])


def _sides(deciding: Sequence[Change], ruling: Ruling, where: str) -> str:
    """What is better and what is worse, that of the measure that says most first."""
    lines = []
    for sign in (ruling.sign, -ruling.sign):
        of_side = [it for at, it in enumerate(deciding) if ruling.passes(at) and ruling.signs[at] == sign]
        told = [f"{name_of(it)}, {_instead(it)}" for it in of_side]
        lines += [f"{'Better' if sign > 0 else 'Worse'}{_there(where)}: {'; '.join(told)}."] if told else []
    return " ".join(lines)


def _does(change: Change, subject: str, sign: int, also: str = "") -> str:
    """What the robot does instead of what it does under the baseline; the sign is 0 where only these trainings do."""
    if change.measure.is_while_training and is_share(change) and "success" in change.name:
        told = f"{_instead(change)} of its episodes succeed {change.measure.manner}"
        return f"The {subject} {also}learns {'faster' if sign > 0 else 'more slowly'}: {told}" if sign else told
    if change.is_relative:
        return f"The {name_of(change)} is {also}{_instead(change)}"
    if change.name == TIME:
        return f"The {subject} {also}reaches its target in {_instead(change)}"
    if is_share(change) and "success" in change.name:
        return f"The {subject} {also}succeeds in {_instead(change)} of its episodes"
    return f"{capitalised(name_of(change))} is {also}{_instead(change)}"


def _instead(change: Change) -> str:
    if change.is_relative:
        return relative_text(change)
    baseline, proposed = short_values(change)
    unit = proposed.partition(" ")[2]
    return f"{proposed}{INSTEAD}{baseline} {unit}".rstrip()


def _no_difference(deciding: Sequence[Change], ruling: Ruling, subject: str, where: str, same_steps: bool) -> str:
    if is_same(deciding, ruling, same_steps=same_steps):
        return f"The {subject} takes the same steps with either reward, bit for bit{_there(where)}."
    if ruling.small is not None:
        first = deciding[0]
        size = size_text(first, ruling.small)
        return f"{capitalised(name_of(first))} differs by less than {size}{_there(where)}{allowance_text([first])}."
    margins = listed([margin_text(it) for it in deciding])
    return f"The rewards differ by less than {margins}{_there(where)}{allowance_text(deciding)}."


def _not_enough(deciding: Sequence[Change], where: str) -> str:
    fewest, most = sorted(deciding[0].counts)
    if fewest != most:
        return f"These trainings are not enough to tell{_there(where)}."
    told = f"{most:,} training{'s' * (most != 1)} of each reward {'is' if most == 1 else 'are'} not enough to tell"
    return f"{told}{_there(where)}."


def _there(where: str) -> str:
    return f", on average {where}" if where else ""
