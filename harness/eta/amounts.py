"""What was seen of measures under two rewards, in words: differences, intervals, values, and trainings that failed.

A difference and how many trainings failed stand before any word of better or worse. The full texts have three digits,
the short ones, for the first screen, two.
"""

import math
from collections.abc import Callable, Sequence

from harness.eta.behaviour_change import Change
from harness.eta.headline import SHORT, difference_of, is_hardly_learned, is_share, name_of
from harness.eta.splits import Names

MOST_DECIMALS = 6
"""A number that needs more has an exponent."""
ROUNDING = 1e-9
"""Means that differ by less, relatively, are the same."""
MOST_OF_PERCENT = 2
"""A percentage has no more decimals than these."""
LUCK = 0.05
"""A share of failing trainings that would show no failure more rarely than this is ruled out."""


def seen_text(names: Names, deciding: Sequence[Change], where: str, asides: Sequence[str]) -> str:
    """What was seen of every measure, a sentence each; how many trainings failed, or learned, stands with the first.

    Args:
        names: The names of the rewards.
        deciding: The measures that decide.
        where: Over which places these are means, in words; empty for a single place.
        asides: What stands before the number of each measure, such as that the answer is not about it.
    """
    counted = counted_text(names, deciding)
    told = zip(asides, deciding, strict=True)
    lines = [capitalised(f"{aside}{_whole(names, it, where, is_first=it is deciding[0])}") for aside, it in told]
    if is_hardly_learned(deciding[0]):
        return " ".join([f"{counted}.", *(f"{line}." for line in lines)])
    return " ".join([f"{lines[0]}; {counted}.", *(f"{line}." for line in lines[1:])])


def short_seen_text(names: Names, deciding: Sequence[Change], asides: Sequence[str]) -> str:
    """The differences alone, with their intervals, and how many trainings failed or learned."""
    told = zip(asides, deciding, strict=True)
    differences = ", ".join(f"{aside}{name_of(it)} {difference_text(it, 2)}{_side(it)}" for aside, it in told)
    return f"{capitalised(differences)}. {counted_text(names, deciding)}."


def difference_text(change: Change, digits: int, where: str = "") -> str:
    """The difference with its interval, such as ``+19.0 points (+4.0 to +34.0)``.

    Args:
        change: A measure that has a value under both rewards.
        digits: How many digits its values have.
        where: What stands before the interval, in words.
    """
    write, unit = _signed(change, digits)
    there = f" on average {where}" if where else ""
    told = f"{write(difference_of(change))}{unit}{there}"
    if change.low is None or change.high is None or change.low == change.high:
        return told  # an interval without a width would be taken for certainty
    ends = (change.low, change.high)
    for more in range(MOST_OF_PERCENT + 1):  # an end beside 0 must not read as 0: a word rests on which side it is
        write, _ = _signed(change, digits, more)
        if all(round(float(write(end).strip("%").replace(",", "")), MOST_DECIMALS) for end in ends if end):
            break
    return f"{told} ({write(ends[0])} to {write(ends[1])})"


def same_text(names: Names, deciding: Sequence[Change]) -> str:
    """What both rewards taught, where it is the same bit for bit: intervals would say nothing."""
    ends = [it for it in deciding if not it.measure.is_while_training] or deciding
    told = ", ".join(f"{name_of(it)} {_values(it, 3)[0]}{_unit(it)}" for it in ends)
    return f"{capitalised(told)} with both; {counted_text(names, deciding)}."


def short_values(change: Change) -> tuple[str, str]:
    """Both values with two digits, or more where two do not tell them apart; the unit stands in the second."""
    baseline, proposed = _values(change, 2)
    unit = "%" if is_share(change) else change.measure.unit
    return baseline, f"{proposed} {unit}".rstrip()


def relative_text(change: Change) -> str:
    """How much higher or lower a measure is that counts relative to the baseline, or to its size."""
    size = f"{_number(100.0 * abs(difference_of(change)), _decimals(change, 2))}%"
    word = "higher" if difference_of(change) > 0.0 else "lower"
    return f"{word} by {size} of its mean size" if change.is_of_size else f"{size} {word}"


def trainings_text(names: Names, counts: tuple[int, int], lost: tuple[int, int] = (0, 0)) -> str:
    """How many trainings there are of each reward, of how many that were begun."""
    begun = [count + none for count, none in zip(counts, lost, strict=True)]
    if counts[0] == begun[0] == counts[1] == begun[1]:
        return f"{counts[0]} training{'s' * (counts[0] != 1)} of each reward"
    baseline, proposed = (f"{count}{f' of {of}' * (of > count)}" for count, of in zip(counts, begun, strict=True))
    others = " (the others left no value)" * any(lost)
    return f"{baseline} training{'s' * (begun[0] != 1)} with {names.baseline}, {proposed} with {names.proposed}{others}"


def failed_of(deciding: Sequence[Change]) -> tuple[int, int] | None:
    """How many trainings of each reward failed, by success at the end; None where that was not measured."""
    return next((it.failed for it in deciding if it.failed is not None and not it.measure.is_while_training), None)


def unseen_text(names: Names, deciding: Sequence[Change]) -> str:
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


def counted_text(names: Names, deciding: Sequence[Change]) -> str:
    """How many trainings failed; how many learned, where hardly any did; else how many there are."""
    failed, of = failed_of(deciding), deciding[0]
    ours, theirs = (count + lost for count, lost in zip(of.counts, of.without, strict=True))
    if failed is None:
        return trainings_text(names, of.counts, of.without)
    is_of_learned = is_hardly_learned(deciding[0])
    first, second = (ours - failed[0], theirs - failed[1]) if is_of_learned else failed
    verb = "learned" if is_of_learned else "failed"
    lost = f" ({listed([f'{count:,}' for count in of.without[::-1]])} left no value)" * any(of.without)
    if (first, ours) == (second, theirs):
        return f"{first:,} of {ours:,} trainings {verb} with either reward{lost}"
    return (
        f"{second:,} of {theirs:,} trainings {verb} with {names.proposed}, {first:,} of {ours:,} with {names.baseline}"
        f"{lost}"
    )


def listed(texts: Sequence[str], word: str = "and") -> str:
    """Texts with commas, and with a word before the last."""
    *most, last = texts
    return f"{', '.join(most)} {word} {last}" if most else last


def _whole(names: Names, change: Change, where: str, *, is_first: bool) -> str:
    """The difference, its interval, and both values; only the first measure has to say whose value is whose."""
    told = f"{name_of(change)} {difference_text(change, 3, where)}{_side(change)}"
    if change.is_relative:
        return told
    baseline, proposed = (f"{value}{_unit(change)}" for value in _values(change, 3))
    if is_first:
        return f"{told}: {proposed} with {names.proposed}, {baseline} with {names.baseline}"
    return f"{told}: {proposed} instead of {baseline}"


def _side(change: Change) -> str:
    """Which side is better, where nobody could know."""
    return ", lower is better" if change.measure.better == "lower" and change.name not in SHORT else ""


def _unit(change: Change) -> str:
    return "%" if is_share(change) else f" {change.measure.unit}".rstrip()


def _values(change: Change, digits: int) -> tuple[str, str]:
    """Both values without their unit."""
    decimals = _decimals(change, digits)
    baseline, proposed = (_number(value, decimals) for value in _scaled(change))
    return baseline, proposed


def _signed(change: Change, digits: int, more: int = 0) -> tuple[Callable[[float], str], str]:
    """Writes a difference, with so many decimals more, and the unit behind it."""
    decimals, scale = _decimals(change, digits) + more, _scale_of(change)
    if change.is_relative:
        of = " of its mean size" if change.is_of_size else ""
        return (lambda value: f"{_with_sign(_number(scale * value, decimals))}%"), of
    unit = "points" if is_share(change) else change.measure.unit
    return (lambda value: _with_sign(_number(scale * value, decimals))), f" {unit}".rstrip()


def _is_percent(change: Change) -> bool:
    return is_share(change) or change.is_relative


def _scale_of(change: Change) -> float:
    """What a value is multiplied by where it is written."""
    return 100.0 if _is_percent(change) else 1.0


def _scaled(change: Change) -> tuple[float, float]:
    """Both values as they are written."""
    scale = _scale_of(change)
    return scale * (change.baseline or 0.0), scale * (change.proposed or 0.0)


def _decimals(change: Change, digits: int) -> int:
    """So many that the difference has two digits, and that it is the difference of the values as they are written."""
    percent = _is_percent(change)
    largest = max(map(abs, _scaled(change)))
    apart = _scale_of(change) * abs(difference_of(change))
    few = digits - 2 if percent else _decimals_for(largest, digits)
    fine = _decimals_for(apart, 2) if apart > ROUNDING * largest else few
    decimals = max(few, min(fine, few + 2 if not percent else 1))
    if change.is_relative:
        return decimals
    most = max(decimals, MOST_OF_PERCENT if percent else few + 2)
    return next((it for it in range(decimals, most) if _adds_up(change, it)), most)


def _adds_up(change: Change, decimals: int) -> bool:
    """Whether the difference is what a reader computes from both values."""
    one, other = (round(value, decimals) for value in _scaled(change))
    told = round(_scale_of(change) * difference_of(change), decimals)
    return abs(other - one - told) < 0.5 * 10.0**-decimals


def _decimals_for(size: float, digits: int) -> int:
    return max(0, digits - 1 - math.floor(math.log10(size))) if size > 0.0 else 0


def _number(value: float, decimals: int) -> str:
    return f"{value:,.{decimals}f}" if decimals <= MOST_DECIMALS else f"{value:.3g}"


def _with_sign(text: str) -> str:
    """A number with its sign; 0 has none that means anything."""
    if text.startswith("-"):
        return text if any(digit in text for digit in "123456789") else f"+{text[1:]}"
    return f"+{text}"


def capitalised(text: str) -> str:
    """A text with a capital first; the rest stays as it is, unlike with `str.capitalize`."""
    return f"{text[0].upper()}{text[1:]}"
