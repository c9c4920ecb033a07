"""The answer in one sentence or two, without a bracket: what a reader with ten seconds takes away.

It says no more than the headline, from which it is made: a word of better or worse stands here only where the test of
the headline says so.
"""

from collections.abc import Sequence

from harness.eta.headline import (
    LEARNED,
    PLANNABLE,
    SHORT,
    TIME,
    Answer,
    Compared,
    Headline,
    is_share,
    margin_text,
)
from harness.eta.verdict.ruling import Ruling

INSTEAD = " instead of "


def lead_of(
    found: Headline,
    deciding: Sequence[Compared],
    ruling: Ruling,
    subject: str,
    where: str = "",
    *,
    same_steps: bool = False,
) -> str:
    """The answer for a reader with little time; that of the headline where it says why nothing was measured.

    Args:
        found: The answer.
        deciding: Measures of behaviour that decide, as `harness.eta.headline.judge` was given them.
        ruling: What the test says of them.
        subject: Who behaves: ``robot`` or ``agent``.
        where: Where this is so, in words, such as ``over 4 places``; empty for a single place.
        same_steps: Whether the policies of both rewards take the same steps, bit for bit.
    """
    if not deciding:
        return found.robot
    if found.answer is Answer.RACED:
        seen = "; ".join(f"{name_of(it)} {_instead(it)}" for it in deciding)
        return f"{seen[0].upper()}{seen[1:]}. The race decides."
    if found.answer in (Answer.HELPS, Answer.HURTS):
        return _decided(deciding, ruling, subject, where)
    if found.answer is Answer.NEITHER_LEARNS:
        return (
            f"Success stays below {LEARNED:.0%} with either reward{_there(where)}. Train longer, or with another "
            "algorithm."
        )
    if found.answer is Answer.NO_DIFFERENCE:
        return _no_difference(deciding, ruling, subject, where, same_steps)
    return _cannot_tell(found, deciding, where)


def short_values(change: Compared) -> tuple[str, str]:
    """Both values with two digits, or with three where two do not tell them apart; the unit stands in the second."""
    short, exact = (tuple(_text(change, it, count) for it in (change.baseline, change.proposed)) for count in (2, 3))
    told = exact if short[0] == short[1] and exact[0] != exact[1] else short
    unit = "%" if is_share(change) else change.measure.unit
    return told[0], f"{told[1]} {unit}".rstrip()


def name_of(change: Compared) -> str:
    """The name of a measure in a sentence, such as ``success``."""
    if change.name == TIME:
        return "time to target"
    return SHORT.get(change.name, change.measure.title or change.name.replace("_", " "))


def _text(change: Compared, value: float | None, count: int) -> str:
    if value is None:
        return "n/a"
    if is_share(change):
        return f"{100 * value:.{0 if count == 2 else 1}f}"
    rounded = float(f"{value:.{count - 1}e}")
    return f"{value:,.0f}" if abs(rounded) >= 10.0**count else f"{rounded:#.{count}g}".rstrip(".")


def _decided(deciding: Sequence[Compared], ruling: Ruling, subject: str, where: str) -> str:
    change = deciding[ruling.decider]
    lines = [f"{_does(change, subject)}{_there(where)}."]
    for at, other in enumerate(deciding):
        if other is change:
            continue
        if not ruling.passes(at):
            lines.append(f"No difference in {name_of(other)} was found.")
        elif ruling.signs[at] == ruling.sign:
            lines.append(f"{_does(other, subject, 'also ')}.")
        else:
            word = "worse" if ruling.sign > 0 else "better"
            lines.append(f"But {name_of(other)} is {word}: {_instead(other)}.")
    return " ".join(lines)


def _does(change: Compared, subject: str, also: str = "") -> str:
    """What the robot does under the proposed reward instead of what it does under the baseline."""
    if change.name == TIME:
        return f"The {subject} {also}reaches its target in {_instead(change)}"
    if is_share(change) and "success" in change.name:
        return f"The {subject} {also}succeeds in {_instead(change)} of its episodes"
    return f"{name_of(change).capitalize()} is {also}{_instead(change)}"


def _instead(change: Compared) -> str:
    baseline, proposed = short_values(change)
    unit = proposed.partition(" ")[2]
    return f"{proposed}{INSTEAD}{baseline} {unit}".rstrip()


def _no_difference(deciding: Sequence[Compared], ruling: Ruling, subject: str, where: str, same_steps: bool) -> str:
    if same_steps and ruling.small is None:
        return f"The {subject} takes the same steps with either reward, bit for bit{_there(where)}."
    if ruling.small is not None:
        change = deciding[0]
        margin = f"{100 * ruling.small:g} points" if is_share(change) else f"{ruling.small:.0%}"
        return f"{name_of(change).capitalize()} differs by less than {margin}{_there(where)}."
    margins = " and by less than ".join(map(margin_text, deciding))
    return f"The rewards differ by less than {margins}{_there(where)}."


def _cannot_tell(found: Headline, deciding: Sequence[Compared], where: str) -> str:
    """How many trainings would tell."""
    seeds = deciding[0].seeds
    told = (
        f"{seeds} training{'s' * (seeds != 1)} of each reward {'is' if seeds == 1 else 'are'} not enough{_there(where)}"
    )
    needed = found.seeds_to_decide
    if needed is None or needed[1] > PLANNABLE * needed[0]:
        return f"{told}."
    return f"{told}: it takes {needed[0]:,} to {needed[1]:,} to tell."


def at_most_text(deciding: Sequence[Compared]) -> str:
    """How large the differences can be, either way, by their 90 % intervals; empty where there is none."""
    most = [f"{name_of(it)} by at most {text}" for it in deciding if (text := _at_most(it))]
    if not most:
        return ""
    first, *others = most
    name, _, amount = first.partition(" by ")
    return f"So far, {' and '.join([f'{name} differs by {amount}', *others])}, either way."


def _at_most(change: Compared) -> str:
    """How large the difference of a measure can be; empty where that is not known."""
    if change.likely is None:
        return ""
    most = max(map(abs, change.likely))
    if is_share(change):
        return f"{100 * min(most, 1.0):.0f} points"
    return f"{most:#.2g}".rstrip(".") + (f" {change.measure.unit}" if change.measure.unit else "")


def _there(where: str) -> str:
    return f", on average {where}" if where else ""
