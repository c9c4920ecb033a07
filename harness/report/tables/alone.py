"""Rewards that stand alone, as a terminal shows them."""

from collections.abc import Iterator

from rich.console import RenderableType
from rich.text import Text

from harness.report.rows.alone import ALONE, alone_grid, beside, size_text, story
from harness.report.rows.comparison import question
from harness.report.rows.terms import changed_text, terms_grid
from harness.report.tables.grid import show_grid, spaced
from harness.results import Results
from harness.results.alone import Alone

FEW = 3
"""Measures that are shown at a glance."""


def alone_lines(results: Results, *, with_all: bool) -> list[RenderableType]:
    """What was asked, and what each reward paid for; nothing where each has another beside it.

    Args:
        results: The experiment, or the recordings.
        with_all: Whether every measure, every interval and every term is shown.
    """
    if not results.alone:
        return []
    parts = [part for it in results.alone for part in _block(results, it, with_all)]
    told = beside(results, results.alone)
    parts += [Text(), Text(ALONE, style="dim")]
    return [*parts, *spaced([told and f"To compare it with another reward: {told}"]), Text()]


def _block(results: Results, alone: Alone, with_all: bool) -> Iterator[RenderableType]:
    yield Text(f"{question(results)} {size_text(alone)}.", style="bold")
    yield Text(alone.group.title)
    yield from show_grid(alone_grid(alone, None if with_all else FEW))
    yield from spaced([story(alone)])
    for terms in results.terms:
        if (terms.group, terms.reward) == (alone.group, alone.reward):
            if with_all:
                yield from show_grid(terms_grid(terms))
            else:
                yield from spaced([changed_text(terms)])
