"""How many trainings of each reward would tell, where nothing is told yet, if what was seen so far is true."""

from collections.abc import Sequence

from harness.eta.headline import Compared, difference_of, is_hardly_learned, share_undone
from harness.eta.power import Range, seeds_to_tell
from harness.eta.verdict.ruling import Ruling

PLANNABLE = 10
"""A number of trainings that is known only to a larger factor is no plan."""


def needed_of(deciding: Sequence[Compared], ruling: Ruling) -> Range | None:
    """How many trainings of each reward would give a plain word; of several measures one is enough.

    None where no number is known, and where more of the same trainings are no help: where no end of a measure is known,
    in a single place while the answer over all places is open, and where hardly any training learned.
    """
    if ruling.is_held or is_hardly_learned(deciding[0]):
        return None
    known = []
    for it in deciding:
        size, share = abs(difference_of(it)), share_undone(it)
        if it.spread is not None and share is not None:
            found = seeds_to_tell(size, it.spread, it.seeds, ruling.confidence, size / share)
            known += [] if found is None else [found]
    if not known:
        return None
    low, high = min(known)
    more = deciding[0].seeds + 1
    return max(low, more), max(high, more)


def needed_text(needed: Range | None, where: str, noun: str = "trainings of each reward") -> str:
    """The same in a sentence; empty where it is not known, or where more trainings of this kind are no help."""
    if needed is None:
        return ""
    if needed[1] > PLANNABLE * needed[0]:
        return "So few trainings do not tell how many would be enough."
    there = " in each place" if where else ", or fewer in each of several places,"
    return f"If what was seen is true, {range_text(needed)} {noun}{there} would tell."


def range_text(seeds: Range) -> str:
    """A range of whole numbers; of one number that number."""
    low, high = seeds
    return f"{low:,}" if low == high else f"{low:,} to {high:,}"
