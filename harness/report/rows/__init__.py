"""What a report says, as plain data. Terminal, page, summary and records show it, and compute nothing."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Grid:
    """A small table, ready to print: a name in the first column, then values; notes below.

    Attributes:
        headings: One for each column.
        rows: As long as `headings`.
        notes: Lines below.
        title: Above the table. As the heading of the names it would wrap.
    """

    headings: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    notes: Sequence[str]
    title: str = ""


@dataclass(frozen=True)
class Fact:
    """A part of what a report says, with a blank line before it.

    Attributes:
        title: Above it; of an answer the subject and the word, such as ``The robot: HELPS``.
        lines: Sentences, or lines.
        grids: Small tables, below one another.
        narrower: The same tables with less beside each value, where the window is not wide enough for `grids`: two
            ways, of which the last one is for the narrowest window; empty where there is one way.
        kind: ``reading``: how to read what stands above it.
    """

    title: str = ""
    lines: tuple[str, ...] = ()
    grids: tuple[Grid, ...] = ()
    narrower: tuple[tuple[Grid, ...], ...] = ()
    kind: Literal["", "reading"] = ""


STYLES = {
    "HELPS": "bold green",
    "HURTS": "bold red",
    "LEARNS FASTER": "green",
    "LEARNS SLOWER": "red",
    "MIXED": "bold magenta",
    "AHEAD SO FAR": "cyan",
    "BEHIND SO FAR": "cyan",
}
"""Styles of rich for the words of answers in a terminal. The words say everything without a colour too."""
