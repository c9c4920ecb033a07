"""A grid as a terminal shows it. Values stay whole and names readable, however narrow the window is."""

from collections.abc import Iterable, Iterator, Mapping
from itertools import pairwise
from types import MappingProxyType

from rich import box
from rich.cells import cell_len
from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.table import Table
from rich.text import Text

from harness.report.rows import STYLES, Fact, Grid
from harness.text import visible

WIDEST = 100
"""Characters of a line: a wider window does not make longer ones."""


class Terminal(Console):
    """A console that shows hidden characters as escapes, whoever made the text; its own colours stay."""

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        """Called by rich for whatever it prints, and for all that stands in it."""
        whole = _visible(renderable) if isinstance(renderable, Text) else renderable
        for text, style, control in super().render(whole, options):
            yield Segment(text if control else visible(text, keep="\n"), style, control)


def _visible(text: Text) -> Text:
    """Before it is broken into lines, which an escape makes longer."""
    shown = text.copy()
    shown.plain = visible(text.plain, keep="\n")
    return shown


def show(table: RenderableType, err: bool = False) -> None:
    """Print a table, on standard output or on standard error."""
    console = Terminal(stderr=err)
    console.width = min(console.width, WIDEST)
    console.print(table)


NAME = 14
"""A name with up to this many characters stays on one line. A longer one may take several lines at least so long."""
GAP = 2
"""Characters between two columns."""


NO_STYLES: Mapping[str, str] = MappingProxyType({})


def show_grid(grid: Grid, styles: Mapping[str, str] = NO_STYLES) -> list[RenderableType]:
    """The grid with its notes, an empty line before it; nothing if it is empty.

    Args:
        grid: What to show.
        styles: Styles of rich for values that are to stand out, by value.
    """
    parts: list[RenderableType] = [GridTable(grid, styles)] if grid.rows else []
    parts = [Text(grid.title, style="bold"), *parts] if grid.rows and grid.title else parts
    parts += map(Text, grid.notes)
    return [Text(), *parts] if parts else []


class GridTable:
    """A grid as a table. If it is too wide, it is several tables below one another, each with the names to its left."""

    def __init__(self, grid: Grid, styles: Mapping[str, str] = NO_STYLES) -> None:
        self._grid, self._styles = grid, styles

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[RenderableType]:
        """Called by rich, which knows how wide the terminal is."""
        for number, columns in enumerate(divide_columns(self._grid, options.max_width)):
            if number:
                yield Text()
            yield _table(self._grid, columns, options.max_width, self._styles)


def divide_columns(grid: Grid, width: int) -> list[range]:
    """The columns of values of each table: as few tables as `width` characters allow, of about the same size."""
    count = len(grid.headings) - 1
    for tables in range(1, count):
        ends = [1 + count * table // tables for table in range(tables + 1)]
        pieces = [range(*ends_of) for ends_of in pairwise(ends)]
        if all(_width_of(grid, columns) <= width for columns in pieces):
            return pieces
    return [range(column, column + 1) for column in range(1, count + 1)]


def _width_of(grid: Grid, columns: range) -> int:
    """The smallest width of a table with the names and these columns."""
    names = max(_name_width(row[0]) for row in (grid.headings, *grid.rows))
    return names + sum(GAP + _column_width(grid, column) for column in columns)


def _name_width(name: str) -> int:
    """The smallest width of a name: all of it if it is short, else its longest word."""
    return cell_len(name) if cell_len(name) <= NAME else min(NAME, max(map(cell_len, name.split())))


def _column_width(grid: Grid, column: int) -> int:
    return max(cell_len(line) for row in (grid.headings, *grid.rows) for line in row[column].split("\n"))


def _table(grid: Grid, columns: range, width: int, styles: Mapping[str, str]) -> Table:
    """A table. Names stand to the left and may wrap. Values may not, unless a single one is too wide."""
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column(Text(grid.headings[0]), overflow="fold")
    fits = _width_of(grid, columns) <= width
    for column in columns:
        table.add_column(Text(grid.headings[column]), justify="right", no_wrap=fits, overflow="fold")
    for row in grid.rows:  # Text, not str: "[m]" is no markup
        table.add_row(Text(row[0]), *(Text(row[column], styles.get(row[column], "")) for column in columns))
    return table


class FactsTable:
    """Facts of a report below one another. Of several ways to show tables the widest one that fits is taken.

    Args:
        facts: What to show, in this order; those that say nothing are left out.
    """

    def __init__(self, facts: Iterable[Fact]) -> None:
        self._facts = [it for it in facts if any((it.title, *it.lines)) or any(of.rows or of.notes for of in it.grids)]

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[RenderableType]:
        """Called by rich, which knows how wide the terminal is."""
        for number, fact in enumerate(self._facts):
            head = [Text(fact.title, "bold")] * bool(fact.title)
            for line in fact.lines:
                word, colon, rest = line.partition(": ")
                told = Text.assemble((word, STYLES[word]), colon, rest) if word in STYLES else Text(line)
                head.append(Text(line, "dim") if fact.kind == "reading" else told)
            ways = (fact.grids, *fact.narrower)
            fits = (it for it in ways if all(len(divide_columns(grid, options.max_width)) == 1 for grid in it))
            tables = [part for grid in next(fits, ways[min(1, len(ways) - 1)]) for part in show_grid(grid, STYLES)]
            parts = [Text(), *head, *tables] if head else tables
            yield from parts if number else parts[1:]
