"""Facts of a report as a terminal shows them."""

from collections.abc import Iterable, Iterator

from rich.console import Console, ConsoleOptions, RenderableType
from rich.text import Text

from harness.report.rows import Fact
from harness.report.rows.comparison import STYLES
from harness.report.tables.grid import divide_columns, show_grid


class FactsTable:
    """Facts below one another. Tables that have several ways are shown in the widest one that fits into the terminal.

    Args:
        facts: What to show, in this order.
    """

    def __init__(self, facts: Iterable[Fact]) -> None:
        self._facts = [it for it in facts if not it.is_empty]

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[RenderableType]:
        """Called by rich, which knows how wide the terminal is."""
        for number, fact in enumerate(self._facts):
            lines = [*map(_styled, fact.lines)] if fact.kind != "reading" else [Text(it, "dim") for it in fact.lines]
            head = [*([Text(fact.title, "bold")] if fact.title else []), *lines]
            ways = (fact.grids, *fact.narrower)
            fits = (it for it in ways if all(len(divide_columns(grid, options.max_width)) == 1 for grid in it))
            tables = [part for grid in next(fits, ways[min(1, len(ways) - 1)]) for part in show_grid(grid, STYLES)]
            parts = [Text(), *head, *tables] if head else tables
            yield from parts if number else parts[1:]


def _styled(line: str) -> Text:
    """A line; an answer at its beginning stands out."""
    word, colon, rest = line.partition(": ")
    return Text.assemble((word, STYLES[word]), colon, rest) if word in STYLES else Text(line)
