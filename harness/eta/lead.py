"""The answer in a sentence or two, without a bracket: what a reader takes away who has seen the differences.

It says no more than the headline, from which it is made: a word of better or worse stands here only where the test of
the headline says so.
"""

from harness.eta.amounts import capitalised, listed, relative_text, short_values
from harness.eta.behaviour_change import Change
from harness.eta.headline import TIME, Answer, is_share, margin_text, name_of, name_with_article, size_text
from harness.eta.judgement import NO_TEST, TOLD, TRAIN_LONGER, Verdict, allowance_text, end_text

INSTEAD = " instead of "


def lead_of(verdict: Verdict, subject: str) -> str:
    """The answer about the robot in a sentence or two.

    Args:
        verdict: What at least one measure says.
        subject: Who behaves: ``robot`` or ``agent``.
    """
    answer, deciding, ruling, there = verdict.answer, verdict.deciding, verdict.ruling, _there(verdict)
    if answer is Answer.INTERIM:
        return f"{verdict.progress} {NO_TEST}"
    if answer is Answer.NEITHER_LEARNS:
        differ = f" The two differ all the same. {_sides(verdict)}" if ruling.is_decided else ""
        return f"Success is {verdict.below}{there}.{differ} {TRAIN_LONGER}"
    if answer is Answer.MIXED:
        return _sides(verdict)
    if answer in TOLD:
        return _told(verdict, subject)
    if answer is Answer.CANNOT_TELL:
        return TRAIN_LONGER if verdict.hardly_learned else f"{_trainings(deciding[0])} not enough to tell{there}."
    return _no_difference(verdict, subject, there)


def _no_difference(verdict: Verdict, subject: str, there: str) -> str:
    deciding, small = verdict.deciding, verdict.ruling.small
    if verdict.is_same:
        return f"The {subject} takes the same steps with either reward, bit for bit{there}."
    if small is not None:
        first = deciding[0]
        size = size_text(first, small)
        return f"{capitalised(name_of(first))} differs by less than {size}{there}{allowance_text([first])}."
    margins = listed([margin_text(it) for it in deciding])
    return f"The rewards differ by less than {margins}{there}{allowance_text(deciding)}."


def _told(verdict: Verdict, subject: str) -> str:
    """What the robot does instead; then what else passed; then what did not, at the end of the trainings."""
    deciding, first, is_decided = verdict.deciding, verdict.decider, verdict.ruling.is_decided
    sign = verdict.ruling.sign * is_decided
    lines = [f"{_does(deciding[first], subject, sign)}{_there(verdict)}."]
    lines += [f"{_does(deciding[at], subject, sign, 'also ')}." for at in verdict.passing if at != first]
    if not is_decided:
        return f"In these trainings: {lines[0][0].lower()}{' '.join(lines)[1:]} New ones may not differ."
    if verdict.is_little:
        lines.append(f"That is little: less than {margin_text(deciding[first])}.")
    others = (it for at, it in enumerate(deciding) if at not in verdict.passing)
    ends = [it for it in others if not it.measure.is_while_training]
    if verdict.answer in (Answer.LEARNS_FASTER, Answer.LEARNS_SLOWER):
        lines.append(f"{end_text(ends).capitalize()}.")
    elif ends:
        verb = "differs" if len(ends) == 1 else "differ"
        lines.append(f"Whether {listed([name_with_article(it) for it in ends])} {verb} too cannot be told.")
    return " ".join(lines)


def _sides(verdict: Verdict) -> str:
    """What is better and what is worse, that of the measure that says most first."""
    sign = verdict.ruling.sign
    return " ".join(
        f"{'Better' if side > 0 else 'Worse'}{_there(verdict)}: {'; '.join(told)}."
        for side in (sign, -sign)
        if (told := [f"{name_of(it)}, {_instead(it)}" for it in verdict.of_side(side)])
    )


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


def _trainings(change: Change) -> str:
    fewest, most = sorted(change.counts)
    if fewest != most:
        return "These trainings are"
    return f"{most:,} training{'s' * (most != 1)} of each reward {'is' if most == 1 else 'are'}"


def _there(verdict: Verdict) -> str:
    return f", on average {verdict.where}" if verdict.where else ""
