"""Two groups of recorded runs, read in lock-step to the end of the shortest: their curves, and what is odd in them."""

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from itertools import zip_longest
from pathlib import Path

import numpy as np

from harness.arrays import Float
from harness.eta.curve import GroupCurve, Kind
from harness.log import Log, Rows
from harness.log.log import ROWS
from harness.reward import Reward
from harness.score.csv_steps import EVENTS
from harness.score.scorer import Payer, pay_column

HELD = 250_000
"""The most rows that are in memory at once, of all runs together."""
ROWS_SEEN = 1_000
"""Rows of a piece in which different rewards are counted."""
FEW = 10
"""So few different rewards may be paid alike in two trainings by chance; equal runs that pay more are copies."""
UNLIKE_METRES = 20.0
"""Begin distances that differ by this factor between two groups are hardly in one unit."""


class ComparedRows:
    """One group, of which all rows are read, some steps of every run at a time."""

    def __init__(self, group: Sequence[Log], other: Reward | None, kind: Kind, with_events: bool) -> None:
        self.group, self._with_events = group, with_events
        self.own, self._scored = GroupCurve(len(group), kind), GroupCurve(len(group), kind)
        self._payers = [Payer(other, run) for run in group] if other is not None else []
        self._finite, self.left_out = True, 0
        self.rows = [0] * len(group)
        self._digests = [hashlib.sha256() for _ in group]
        self._values: list[set[float]] = [set() for _ in group]
        self._metres, self._starts = 0.0, 0

    @property
    def other(self) -> GroupCurve | None:
        """The curve of what the other group's reward would have paid; None if nobody asked, or it is not finite."""
        return self._scored if self._payers and self._finite else None

    @property
    def begin_distance(self) -> float | None:
        """The mean over all compared rows, [m]; None where the files have no distances."""
        return self._metres / self._starts if self._starts else None

    def pieces(self, rows: int) -> list[Iterator[Rows]]:
        """The rows of each run, so many at a time, of the columns that are compared."""
        read = []
        for number, run in enumerate(self.group):
            paid = (pay_column(run), *(EVENTS if self._with_events else ()))
            more = (name for name in ("begin_distance",) if name in run)
            read.append(run.pieces([*paid, *more, *(self._payers[number].columns if self._payers else ())], rows))
        return read

    def add(self, pieces: Sequence[Rows | None], steps: int) -> None:
        """Take the next piece of each run, of which `steps` rows are compared."""
        there = [piece for piece in pieces if piece is not None]
        self.rows = [rows + (len(it) if it else 0) for rows, it in zip(self.rows, pieces, strict=True)]
        self.left_out += sum(len(piece) - steps for piece in there)
        if not steps:
            return
        recorded = [piece[pay_column(run)] for piece, run in zip(there, self.group, strict=True)]
        paid = self._with_event_terms(there, recorded, steps)
        self.own.add(paid)
        for digest, values, run in zip(self._digests, self._values, paid, strict=True):
            digest.update(run.tobytes())
            if len(values) <= FEW:
                values.update(np.unique(run[:ROWS_SEEN]).tolist())
        for begin in (piece["begin_distance"] for piece in there if "begin_distance" in piece.columns):
            self._metres, self._starts = self._metres + float(begin[:steps].sum()), self._starts + steps
        if self._payers and self._finite:
            with np.errstate(all="ignore"):  # a reward may divide by anything where it then takes another value
                scored = [payer.pay(piece).total for payer, piece in zip(self._payers, there, strict=True)]
            values_of_other = self._with_event_terms(there, scored, steps)
            self._finite = bool(np.isfinite(values_of_other).all())
            self._scored.add(values_of_other)

    def _with_event_terms(self, pieces: Sequence[Rows], paid: Sequence[Float], steps: int) -> Float:
        """What the first `steps` rows of each piece are paid, (runs, steps)."""
        if self._with_events:
            events = (np.sum([piece[name] for name in EVENTS], axis=0) for piece in pieces)
            paid = [shaped + event for shaped, event in zip(paid, events, strict=True)]
        return np.stack([run[:steps] for run in paid])

    def digests(self, certain: bool) -> dict[str, list[Log]]:
        """Runs by what was paid in all compared steps.

        Args:
            certain: Of those that paid more different rewards than by chance alike, or of the others that vary at all.
        """
        found: dict[str, list[Log]] = {}
        for run, digest, values in zip(self.group, self._digests, self._values, strict=True):
            if (len(values) > FEW) == certain and len(values) > 1:
                found.setdefault(digest.hexdigest(), []).append(run)
        return found

    @property
    def copies(self) -> dict[Log, Log]:
        """Each run that is a copy, and the one that it is a copy of."""
        return {copy: runs[0] for runs in self.digests(certain=True).values() for copy in runs[1:]}


def stream_groups(
    groups: Sequence[Sequence[Log]], others: Sequence[Reward | None], kind: Kind, with_events: bool
) -> list[ComparedRows]:
    """Read all rows of both groups, the same steps of every run at once, up to the end of the shortest run of all.

    The rest is read, too: a fault in it is a fault of the file.
    """
    count = len(groups[0])
    runs = [run for group in groups for run in group]
    rows = max(1, min(ROWS, HELD // len(runs)))
    sides = [ComparedRows(group, other, kind, with_events) for group, other in zip(groups, others, strict=True)]
    for pieces in zip_longest(*(of_run for side in sides for of_run in side.pieces(rows))):
        steps = min(0 if piece is None else len(piece) for piece in pieces)
        for side, of in zip(sides, (pieces[:count], pieces[count:]), strict=True):
            side.add(of, steps)
    return sides


# What a reader has to know


def copy_notes(copies: Sequence[Mapping[Log, Log]]) -> Iterator[str]:
    """Which runs count once."""
    for of in copies:
        copied: dict[Path, list[Path]] = {}
        for copy, first in of.items():
            copied.setdefault(first.facts.path, []).append(copy.facts.path)
        for path, others in copied.items():
            yield f"{_listed(others)} {'is' if len(others) == 1 else 'are'} equal to '{path}': the run counts once"


def notes_of(sides: Sequence[ComparedRows]) -> Iterator[str]:
    """What a reader has to know of budgets, equal runs and units."""
    for run in (run for side in sides for run in side.group):
        yield from (f"'{run.facts.path}': {note}" for note in run.facts.notes)
    lengths = {run.facts.path: rows for side in sides for run, rows in zip(side.group, side.rows, strict=True)}
    shortest = min(lengths, key=lambda path: lengths[path])
    longer = [rows for rows in lengths.values() if rows > lengths[shortest]]
    if longer:
        told = f"All runs are cut to the {lengths[shortest]:,} steps of the shortest, '{shortest}'"
        far = 2 * lengths[shortest] < sorted(lengths.values())[len(lengths) // 2]
        yield f"{told}; the longest has {max(longer):,}{'. Leave it out if it broke off' * far}"
    for side in sides:
        for runs in side.digests(certain=False).values():
            if len(runs) > 1:
                yield f"{_listed([run.facts.path for run in runs])} record the same rewards; each counts"
    if [run.facts.path for run in sides[0].group] != [run.facts.path for run in sides[1].group]:
        yield from _equal_across(*({**side.digests(True), **side.digests(False)} for side in sides))
    begins = [side.begin_distance for side in sides]
    if begins[0] and begins[1] and not 1.0 / UNLIKE_METRES < begins[1] / begins[0] < UNLIKE_METRES:
        yield (
            f"Begin distances are {begins[0]:.3g} in the baseline's runs and {begins[1]:.3g} in the proposed ones: "
            "are both in metres?"
        )


def _equal_across(baseline: Mapping[str, list[Log]], proposed: Mapping[str, list[Log]]) -> Iterator[str]:
    for digest in baseline.keys() & proposed.keys():
        both = [baseline[digest][0].facts.path, proposed[digest][0].facts.path]
        yield f"{_listed(both)} record the same rewards: between them there is nothing to compare"


def _listed(paths: Sequence[Path]) -> str:
    *most, last = (f"'{path}'" for path in paths)
    return f"{', '.join(most)} and {last}" if most else last
