"""What was seen of measures under two rewards, in words: differences, intervals, values, and trainings that failed.

A difference and how many trainings failed stand before any word of better or worse. The full texts have three digits,
the short ones, for the first screen, two.
"""

import math
from collections.abc import Callable, Sequence

from harness.eta.headline import SHORT, Compared, Names, difference_of, is_hardly_learned, is_share, name_of

MOST_DECIMALS = 6
"""A number that needs more has an exponent."""
LUCK = 0.05
"""A share of failing trainings that would show no failure more rarely than this is ruled out."""


def seen_text(names: Names, deciding: Sequence[Compared], where: str) -> str:
    """What was seen of every measure, a sentence each; how many trainings failed, or learned, stands with the first.

    Args:
        names: The names of the rewards.
        deciding: The measures that decide.
        where: Over which places these are means, in words; empty for a single place.
    """
    counted = _counted(names, deciding)
    lines = [_whole(names, it, where, is_first=it is deciding[0]) for it in deciding]
    if is_hardly_learned(deciding[0]):
        return " ".join([f"{counted}.", *(f"{line}." for line in lines)])
    return " ".join([f"{lines[0]}; {counted}.", *(f"{line}." for line in lines[1:])])


def short_seen_text(names: Names, deciding: Sequence[Compared]) -> str:
    """The differences alone, with their intervals, and how many trainings failed or learned."""
    differences = _capitalised(", ".join(f"{name_of(it)} {difference_text(it, 2)}" for it in deciding))
    return f"{differences}. {_counted(names, deciding)}."


def difference_text(change: Compared, digits: int, where: str = "") -> str:
    """The difference with its interval, such as ``+19.0 points (+4.0 to +34.0)``.

    Args:
        change: A measure that has a value under both rewards.
        digits: How many digits its values have.
        where: What stands before the interval, in words.
    """
    write, unit = _signed(change, digits)
    there = f" on average {where}" if where else ""
    told = f"{write(difference_of(change))}{unit}{there}"
    if change.low is None or change.high is None:
        return told
    return f"{told} ({write(change.low)} to {write(change.high)})"


def short_values(change: Compared) -> tuple[str, str]:
    """Both values with two digits, or more where two do not tell them apart; the unit stands in the second."""
    baseline, proposed = _values(change, 2)
    unit = "%" if is_share(change) else change.measure.unit
    return baseline, f"{proposed} {unit}".rstrip()


def trainings_text(names: Names, counts: tuple[int, int]) -> str:
    """How many trainings there are of each reward."""
    baseline, proposed = counts
    if baseline == proposed:
        return f"{baseline} training{'s' * (baseline != 1)} of each reward"
    return f"{baseline} training{'s' * (baseline != 1)} with {names.baseline}, {proposed} with {names.proposed}"


def failed_of(deciding: Sequence[Compared]) -> tuple[int, int] | None:
    """How many trainings of each reward failed, by success at the end; None where that was not measured."""
    return next((it.failed for it in deciding if it.failed is not None and not it.measure.is_while_training), None)


def unseen_text(names: Names, deciding: Sequence[Compared]) -> str:
    """How many trainings may fail though none of those that were seen did; empty where one failed."""
    failed = failed_of(deciding)
    if failed is None or any(failed):
        return ""
    counts = deciding[0].counts
    baseline, proposed = (f"{1.0 - LUCK ** (1.0 / count):.0%}" for count in counts)
    if counts[0] == counts[1]:
        return (
            f"No training failed, but {counts[0]:,} of each reward cannot rule out that up to {baseline} fail under "
            "either."
        )
    return (
        f"No training failed, but {counts[0]:,} with {names.baseline} and {counts[1]:,} with {names.proposed} cannot "
        f"rule out that up to {baseline} and {proposed} fail."
    )


def listed(texts: Sequence[str]) -> str:
    """Texts with commas, and with *and* before the last."""
    *most, last = texts
    return f"{', '.join(most)} and {last}" if most else last


def _counted(names: Names, deciding: Sequence[Compared]) -> str:
    """How many trainings failed; how many learned, where hardly any did; else how many there are."""
    failed, (ours, theirs) = failed_of(deciding), deciding[0].counts
    if failed is None:
        return trainings_text(names, (ours, theirs))
    is_of_learned = is_hardly_learned(deciding[0])
    first, second = (ours - failed[0], theirs - failed[1]) if is_of_learned else failed
    verb = "learned" if is_of_learned else "failed"
    if (first, ours) == (second, theirs):
        return f"{first:,} of {ours:,} trainings {verb} with either reward"
    return (
        f"{second:,} of {theirs:,} trainings {verb} with {names.proposed}, {first:,} of {ours:,} with {names.baseline}"
    )


def _whole(names: Names, change: Compared, where: str, *, is_first: bool) -> str:
    """The difference, its interval, and both values; only the first measure has to say whose value is whose."""
    side = ", lower is better" if change.measure.better == "lower" and change.name not in SHORT else ""
    told = f"{_capitalised(name_of(change))} {difference_text(change, 3, where)}{side}"
    if change.is_relative:
        return told
    baseline, proposed = (f"{value}{_unit(change)}" for value in _values(change, 3))
    if is_first:
        return f"{told}: {proposed} with {names.proposed}, {baseline} with {names.baseline}"
    return f"{told}: {proposed} instead of {baseline}"


def _unit(change: Compared) -> str:
    return "%" if is_share(change) else f" {change.measure.unit}".rstrip()


def _values(change: Compared, digits: int) -> tuple[str, str]:
    """Both values without their unit, so exact that they tell apart what differs."""
    values = (change.baseline or 0.0, change.proposed or 0.0)
    if is_share(change):
        decimals = _decimals_of_share(difference_of(change), digits)
        baseline, proposed = (f"{100 * value:.{decimals}f}" for value in values)
    else:
        decimals = _decimals(change, digits)
        baseline, proposed = (_number(value, decimals) for value in values)
    return baseline, proposed


def _signed(change: Compared, digits: int) -> tuple[Callable[[float], str], str]:
    """Writes a difference, and the unit behind it."""
    if is_share(change) or change.is_relative:
        decimals = _decimals_of_share(difference_of(change), digits)
        sign = "%" if change.is_relative else ""
        return (lambda value: f"{_with_sign(f'{100 * value:.{decimals}f}')}{sign}"), "" if sign else " points"
    decimals = _decimals(change, digits)
    return (lambda value: _with_sign(_number(value, decimals))), f" {change.measure.unit}".rstrip()


def _decimals_of_share(difference: float, digits: int) -> int:
    """Of a percentage: more where the difference would look like none."""
    decimals = digits - 2
    return decimals if not difference or abs(100 * difference) >= 0.5 * 10.0**-decimals else decimals + 1


def _decimals(change: Compared, digits: int) -> int:
    """So many that the larger value has its digits, and the difference all but one of them, as far as that is sane."""
    size = max(abs(change.baseline or 0.0), abs(change.proposed or 0.0))
    decimals = _decimals_for(size, digits)
    return max(decimals, min(_decimals_for(abs(difference_of(change)), digits - 1), decimals + 2))


def _decimals_for(size: float, digits: int) -> int:
    return max(0, digits - 1 - math.floor(math.log10(size))) if size > 0.0 else 0


def _number(value: float, decimals: int) -> str:
    return f"{value:,.{decimals}f}" if decimals <= MOST_DECIMALS else f"{value:.3g}"


def _with_sign(text: str) -> str:
    """A number with its sign; 0 has none that means anything."""
    if text.startswith("-"):
        return text if any(digit in text for digit in "123456789") else f"+{text[1:]}"
    return f"+{text}"


def _capitalised(text: str) -> str:
    return f"{text[0].upper()}{text[1:]}"
