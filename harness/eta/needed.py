"""How many trainings of each reward would tell, where nothing is told yet, and under which condition."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from harness.eta.amounts import listed
from harness.eta.headline import Compared, difference_of, is_hardly_learned, margin_of, margin_text
from harness.eta.power import Range, seeds_to_tell
from harness.eta.verdict.ruling import Ruling

PLANNABLE = 10
"""A number of trainings that is known only to a larger factor is no plan."""


class Needed(NamedTuple):
    """How many trainings of each reward would tell."""

    seeds: Range
    condition: str
    """What has to be so for that, in words."""


def needed_of(deciding: Sequence[Compared], ruling: Ruling) -> Needed | None:
    """How many trainings of each reward would tell: the difference that was seen, else differences of the margins.

    None where intervals lie within the margins: there trainings lack that were not seen, and not a smaller spread. And
    where more of the same trainings are no help: in a single place while the answer over all places is open, and where
    hardly any training learned.
    """
    if ruling.is_held or is_hardly_learned(deciding[0]):
        return None
    seen = _ranges(deciding, ruling, [abs(difference_of(it)) for it in deciding])
    known = [it for it in seen if it is not None]
    if known:
        return Needed(_beyond(deciding[0].seeds, min(known)), "what was seen so far")  # one measure is enough
    if all(_is_inside(it, margin_of(it)) for it in deciding):
        return None
    small = _ranges(deciding, ruling, [margin_of(it) for it in deciding])
    known = [it for it in small if it is not None]
    if not known or len(known) < len(small):
        return None
    low, high = (max(ends) for ends in zip(*known, strict=True))
    condition = listed([margin_text(it) for it in deciding], "or")
    return Needed(_beyond(deciding[0].seeds, (low, high)), condition)


def needed_text(needed: Needed | None, where: str, noun: str = "trainings of each reward") -> str:
    """The same in a sentence; empty where it is not known, or where more trainings of this kind are no help."""
    if needed is None:
        return ""
    if needed.seeds[1] > PLANNABLE * needed.seeds[0]:
        return "So few trainings do not tell how many would be enough."
    there = " in each place" if where else ""
    return f"If the difference is {needed.condition}, {range_text(needed.seeds)} {noun}{there} would tell."


def range_text(seeds: Range) -> str:
    """A range of whole numbers; of one number that number."""
    low, high = seeds
    return f"{low:,}" if low == high else f"{low:,} to {high:,}"


def _is_inside(change: Compared, margin: float) -> bool:
    return change.low is not None and change.high is not None and -margin < change.low and change.high < margin


def _ranges(changes: Sequence[Compared], ruling: Ruling, sizes: Sequence[float]) -> list[Range | None]:
    """How many trainings would tell a difference of such a size in each measure; None where they would be too many.

    Measures without a known spread, or with no size, are left out. Where p was raised the first one alone counts.
    """
    ranges = []
    asked = ruling.asked * len(changes)
    for change, size in zip(changes[:1] if ruling.is_floored else changes, sizes, strict=False):
        if change.spread is not None and size > 0.0 and math.isfinite(size):
            found = seeds_to_tell(size, change.spread, change.seeds, asked, ruling.level)
            ranges.append(_with_floor(found, size, ruling) if found and ruling.is_floored else found)
    return ranges


def _beyond(seeds: int, found: Range) -> Range:
    """More than there are."""
    low, high = found
    return max(low, seeds + 1), max(high, seeds + 1)


def _with_floor(found: Range, size: float, ruling: Ruling) -> Range:
    """At least so many that luck alone hardly shows no failure where the means are equal, or nothing but failures."""
    if not 0.0 < size < 1.0:
        return found
    low, high = (math.ceil(math.log(ruling.level / 2.0 / asked) / math.log1p(-size)) for asked in (1, ruling.asked))
    return max(found[0], low), max(found[1], high)
