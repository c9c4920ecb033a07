"""Tables of a terminal, whose values stay whole however narrow it is: any grid, and the overview of an experiment."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from types import MappingProxyType

from rich import box
from rich.cells import cell_len
from rich.console import Console, ConsoleOptions, Group, Group as Together, RenderableType
from rich.segment import Segment
from rich.table import Table
from rich.text import Text

from harness.report.rows.comparison import (
    ALONE,
    CHOOSING,
    CHOOSING_TITLE,
    POOLED_TITLE,
    STYLES,
    advice,
    alone_grid,
    basis_text,
    beside,
    beside_answer,
    choosing_told,
    count_cells,
    interim_text,
    pooled_answers,
    question,
    remarks_on_cells,
    size_text,
    story,
)
from harness.report.rows.ranking import AGREEMENT, CHOICE, EXPLANATION, TITLE, task_rows
from harness.report.rows.ratios import Grid, split_grid
from harness.report.rows.returns import changed_text, matrix_title, never_texts, return_grid, terms_grid
from harness.results import Results
from harness.results.alone import Alone
from harness.results.comparison import Comparison
from harness.results.overview import (
    PAY,
    group_name,
    line_names,
    overview_of,
    overview_row,
    reward_names,
    shared_text,
    varying_kinds,
)
from harness.results.ranking import ranking_of
from harness.results.return_matrix import ReturnMatrix
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


def show_titled(title: str, *grids: Grid) -> RenderableType:
    """Grids below a title."""
    return Group(Text(title, style="bold"), *(part for grid in grids for part in show_grid(grid)), Text())


def spaced(lines: Iterable[str]) -> list[RenderableType]:
    """Each line that is not empty, below an empty line."""
    return [part for line in lines if line for part in (Text(), Text(line))]


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


def ranking_table(results: Results, details: bool) -> RenderableType | None:
    """The answer in each task, and on request what it rests on; None if there is nothing to compare."""
    tasks = ranking_of(results).tasks
    if not tasks:
        return None
    parts: list[RenderableType] = [Text(), Text(TITLE, style="bold")]
    for rows in map(task_rows, tasks):
        parts += [Text(rows.title), *(Text(f"  {line}") for line in rows.lines)]
        grids = [*(table.grid for table in rows.ranks), rows.choices, rows.agreements] if details else []
        parts += [part for grid in grids for part in show_grid(grid)]
    told = [Text(), Text(" ".join((EXPLANATION, CHOICE, AGREEMENT)), style="dim")] if details else []
    return Group(*parts, *told)


def choosing_lines(results: Results) -> list[RenderableType]:
    """Who went furthest, and a line for each candidate; none where none is chosen, or nobody has left yet."""
    told = choosing_told(results)
    if told is None:
        return []
    title, explanation = Text(CHOOSING_TITLE, style="bold"), Text(CHOOSING, style="dim")
    return [Text(told.sentence, style="bold"), Text(), title, *show_grid(told.grid), Text(), explanation, Text()]


def overview_table(results: Results, details: str) -> RenderableType:
    """What is the same in all comparisons, then a line for each. A single comparison is told in sentences.

    Where one of several rewards is chosen, a line for each of them stands before that.

    Args:
        results: The experiment.
        details: The command that shows everything behind the overview.
    """
    combinations = results.combinations
    chosen = choosing_lines(results)
    parts = [*said_lines(results), *chosen]
    parts += _comparisons(results) or (alone_lines(results, with_all=False) if not chosen else [])
    parts += map(Text, dict.fromkeys(mixture.text for it in combinations for mixture in it.measured.mixtures))
    parts += spaced([*_not_split(combinations), *never_texts(results)])
    for matrix in _with_others(results):
        parts += [Text(), Text(matrix_title(matrix), style="bold"), *show_grid(return_grid(matrix))]
    parts += [Text(), Text(count_cells(results), style="bold"), *map(Text, remarks_on_cells(results))]
    told = [Text(f"All numbers behind this: {details}")] if combinations or results.alone else []
    return Together(*parts, *told)


def _comparisons(results: Results) -> list[RenderableType]:
    """The lines, and below them what to know of them; of one comparison both answers and how to get one."""
    combinations = results.combinations
    if not combinations:
        return []
    parts = [*interim_lines(results), comparison_lines(combinations)]
    lines = [*(line for it in combinations for line in beside_answer(it)), *map(basis_text, combinations)]
    if len(combinations) == 1:
        only = combinations[0]
        lines = [only.headline.robot, *lines, only.pay_sentence, advice(results, only)]
    return [*parts, *spaced(dict.fromkeys(lines))]


def interim_lines(results: Results) -> list[RenderableType]:
    """A line that the plan is not trained to its end; none where it is."""
    told = interim_text(results)
    return [Text(told, style="bold")] if told else []


def said_lines(results: Results) -> list[RenderableType]:
    """How what was found was sorted and read; none of an experiment, which knows what it trained."""
    return [*(Text(f"{line}.") for line in results.said), *([Text()] if results.said else [])]


def pooled_lines(combinations: Sequence[Comparison]) -> list[RenderableType]:
    """The answers over all places, where there are several."""
    answers = pooled_answers(combinations)
    lines = [Text.assemble((answer, STYLES.get(answer, "bold")), f": {told}") for answer, told in answers]
    return [Text(POOLED_TITLE, style="bold"), *lines] if lines else []


def comparison_lines(combinations: Sequence[Comparison]) -> RenderableType:
    """What is the same in all comparisons, the answers over all places, a line for each, and how to read them."""
    shared = Text(shared_text(combinations), style="bold")
    wide = overview_grids(combinations, with_intervals=True)
    middle = overview_grids(combinations, with_intervals=False)
    pooled = pooled_lines(combinations)
    answers = [Text(), *pooled] if pooled else []
    reading = Text(overview_of(combinations).reading, style="dim")
    return Together(shared, *answers, WideOrNarrow(wide, middle, list(map(_narrow, middle))), Text(), reading)


class WideOrNarrow:
    """A line per comparison: the widest that fits into the terminal, else the second, below one another."""

    def __init__(self, *lines: Sequence[Grid]) -> None:
        """Take the same lines, the widest first."""
        self._lines = lines

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[RenderableType]:
        """Called by rich, which knows how wide the terminal is."""
        fits = (it for it in self._lines if all(len(divide_columns(grid, options.max_width)) == 1 for grid in it))
        for grid in next(fits, self._lines[1]):
            yield from show_grid(grid, STYLES)


def _narrow(grid: Grid) -> Grid:
    """The same lines with the change of pay and its ruler alone."""
    if PAY not in grid.headings:
        return grid
    at = grid.headings.index(PAY)
    rows: list[tuple[str, ...]] = [(*row[:at], *row[at + 1 : at + 3]) for row in grid.rows]
    return grid._replace(headings=(*grid.headings[:at], "pay", "ruler"), rows=rows)


def overview_grids(combinations: Sequence[Comparison], *, with_intervals: bool) -> list[Grid]:
    """A line per comparison. If both groups and rewards vary, there is a grid for each group."""
    varying, overview = varying_kinds(combinations), overview_of(combinations)
    if not varying or len({it.proposed for it in combinations}) == 1:
        names = zip(line_names(combinations), combinations, strict=True)
        rows = [overview_row(name, it, with_intervals, overview) for name, it in names]
        return [Grid(overview.headings, rows, [])]
    named = zip(reward_names(combinations), combinations, strict=True)
    blocks: dict[str, list[tuple[str, ...]]] = {}
    for reward, it in named:
        row = overview_row(reward, it, with_intervals, overview)
        blocks.setdefault(group_name(it, varying), []).append(row)
    return [Grid(overview.headings, rows, [], name) for name, rows in blocks.items()]


def _not_split(combinations: Sequence[Comparison]) -> list[str]:
    """Why a reward could not pay the runs of another one, each reason once. It explains why an eta was not split."""
    numbers = (it.number for it in combinations if it.seeds)
    told = (it.index_splits for it in numbers if it.pay is None and not it.is_split)
    return list(dict.fromkeys(note for splits in told for note in split_grid(splits).notes))


def _with_others(results: Results) -> list[ReturnMatrix]:
    """The first table of returns of each group that has rewards which taught nobody: the lines above leave them out."""
    first = {matrix.group: matrix for matrix in reversed(results.returns)}
    return [it for it in first.values() if set(it.returns) - set(it.trained_with)]
