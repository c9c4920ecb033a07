"""How many trainings of each reward would tell, where nothing is told yet, if what was seen so far is true."""

import math
from collections.abc import Sequence

from harness.eta.behaviour_change import Change
from harness.eta.headline import difference_of, is_hardly_learned, margin_of, reaches_of
from harness.eta.interval import ONE_SIDED
from harness.eta.power import Range, seeds_to_tell
from harness.eta.verdict.ruling import Ruling

PLANNABLE = 10
"""A number of trainings that is known only to a larger factor is no plan."""


def needed_of(deciding: Sequence[Change], ruling: Ruling) -> Range | None:
    """How many trainings of each reward would give a plain word, or show that nothing differs; see `_looks_alike`.

    None where no number is known, and where more of the same trainings are no help: where no end of a measure is known,
    in a single place while the answer over all places is open, where hardly any training learned, and where some left
    no value.
    """
    if ruling.is_held or is_hardly_learned(deciding[0]) or any(deciding[0].without):
        return None
    if _looks_alike(deciding, ruling):
        found = [_seeds_for(it, margin_of(it), ONE_SIDED, max(reaches_of(it))) for it in deciding]
        known = [max(filter(None, found))] if all(found) else []
    else:
        found = [_seeds_for(it, abs(difference_of(it)), ruling.confidence, reaches_of(it)[0]) for it in deciding]
        known = list(filter(None, found))
    more = deciding[0].seeds + 1
    return (max(min(known)[0], more), max(min(known)[1], more)) if known else None


def needed_text(deciding: Sequence[Change], ruling: Ruling, where: str, noun: str = "trainings of each reward") -> str:
    """The same in a sentence; empty where it is not known, or where more trainings of this kind are no help."""
    needed = needed_of(deciding, ruling)
    if needed is None:
        return ""
    if needed[1] > PLANNABLE * needed[0]:
        return "So few trainings do not tell how many would be enough."
    # Of one of several places labels are not dealt: more places would not tell of this one.
    there = " in each place" if where else ", in one place or spread over several," * (ruling.corrected is not None)
    condition, end = (
        ("nothing differs", "show it") if _looks_alike(deciding, ruling) else ("what was seen is true", "tell")
    )
    return f"If {condition}, {range_text(needed)} {noun}{there} would {end}."


def _looks_alike(deciding: Sequence[Change], ruling: Ruling) -> bool:
    """Whether what was seen of every measure counts as no difference; then all of them have to be told, else one."""
    return not ruling.is_ahead and all(abs(difference_of(it)) < margin_of(it) for it in deciding)


def _seeds_for(change: Change, size: float, confidence: float, reach: float) -> Range | None:
    if change.spread is None or not size or not math.isfinite(reach):
        return None
    return seeds_to_tell(size, change.spread, change.seeds, confidence, reach / len(change.parts))


def range_text(seeds: Range) -> str:
    """A range of whole numbers; of one number that number."""
    low, high = seeds
    return f"{low:,}" if low == high else f"{low:,} to {high:,}"
