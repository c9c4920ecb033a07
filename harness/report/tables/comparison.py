"""The comparisons of an experiment, as a terminal shows them: a line each at a glance, and all that they rest on."""

from collections.abc import Iterator, Sequence

from rich.console import Console, ConsoleOptions, Group, Group as Together, RenderableType
from rich.text import Text

from harness.report.rows import Grid
from harness.report.rows.comparison import (
    ALONE,
    CHOOSING,
    CHOOSING_TITLE,
    NO_REWARD,
    POOLED_TITLE,
    STYLES,
    advice,
    alone_grid,
    along_grid,
    basis_text,
    behaviour_grids,
    beside,
    beside_answer,
    choosing_told,
    claims_text,
    compared_text,
    count_cells,
    interim_text,
    pooled_answers,
    question,
    remarks_on_cells,
    rewards_text,
    size_text,
    story,
    what_decides,
    word_of,
)
from harness.report.rows.ranking import AGREEMENT, CHOICE, EXPLANATION as RANKED, TITLE, task_rows
from harness.report.rows.ratios import SPLIT, scales_text, split_grid
from harness.report.rows.returns import (
    EXPLANATION,
    INDICES,
    PAY,
    READING,
    changed_text,
    matrix_title,
    never_texts,
    number_grids,
    return_grid,
    terms_grid,
    terms_of,
)
from harness.report.tables.grid import divide_columns, show_grid, show_titled, spaced
from harness.results import Results
from harness.results.comparison import Comparison
from harness.results.overview import (
    PAY as PAY_TITLE,
    group_name,
    index_rows,
    line_names,
    overview_of,
    overview_row,
    reward_names,
    shared_text,
    varying_kinds,
)
from harness.results.ranking import ranking_of
from harness.results.results import ReturnMatrix
from harness.results.trainings import Alone

FEW = 3
"""Measures that are shown at a glance."""
ETAS = ("", "eta_N", "its parts", "eta_P", "its parts")


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
    told = [Text(), Text(" ".join((RANKED, CHOICE, AGREEMENT)), style="dim")] if details else []
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
    grids = [
        [Grid(ETAS, rows, [], f"{INDICES}, each = ruler x behaviour")]
        for it in (True, False)
        if (rows := index_rows(combinations, it))
    ]
    etas = [(name, split.eta) for it in combinations for name, split in it.number.splits.items()]
    missing = dict.fromkeys(f"{name} n/a: {'; '.join(eta.notes)}." for name, eta in etas if eta.value is None)
    parts += [WideOrNarrow(*grids), *map(Text, missing)] if grids else []
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
    if PAY_TITLE not in grid.headings:
        return grid
    at = grid.headings.index(PAY_TITLE)
    rows: list[tuple[str, ...]] = [(*row[:at], *row[at + 1 : at + 3]) for row in grid.rows]
    return grid._replace(headings=(*grid.headings[:at], "pay", "ruler"), rows=rows)


def overview_grids(combinations: Sequence[Comparison], *, with_intervals: bool) -> list[Grid]:
    """A line per comparison. If both groups and rewards vary, there is a grid for each group."""
    varying, overview = varying_kinds(combinations), overview_of(combinations)
    is_one = not varying or len({it.proposed for it in combinations}) == 1
    names = line_names(combinations) if is_one else reward_names(combinations)
    blocks: dict[str, list[tuple[str, ...]]] = {}
    for name, it in zip(names, combinations, strict=True):
        row = overview_row(name, it, with_intervals, overview)
        blocks.setdefault("" if is_one else group_name(it, varying), []).append(row)
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


def comparison_table(results: Results) -> RenderableType:
    """What ``harness report --details`` prints: a block per combination, then the cells."""
    combinations = results.combinations
    first = [*interim_lines(results), *pooled_lines(combinations)]
    blocks: list[RenderableType] = [*said_lines(results), *first, *([Text()] if first else [])]
    blocks += alone_lines(results, with_all=True)
    blocks += [_combination_block(results, it) for it in combinations]
    if any(comparison.has_trainings for comparison in combinations):
        is_split = any(comparison.number.is_split for comparison in combinations)
        read = [READING] if any(comparison.number.pay for comparison in combinations) else []
        told = [scales_text(results.subject), *[SPLIT] * is_split, *read, NO_REWARD, what_decides(results)]
        blocks.append(Text(" ".join(told) + "\n"))
    if results.returns:
        blocks += [
            *(show_titled(matrix_title(it), return_grid(it)) for it in results.returns),
            Text(EXPLANATION + "\n"),
        ]
    blocks.append(Text(count_cells(results), style="bold"))
    return Group(*blocks, *map(Text, remarks_on_cells(results)))


def _combination_block(results: Results, comparison: Comparison) -> RenderableType:
    """The two answers first, then what they rest on. The page shows more, which would fill many screens here."""
    headline = comparison.headline
    parts: list[RenderableType] = [
        Text(comparison.group.title, style="bold"),
        Text(rewards_text(comparison)),
        Text(f"{compared_text(comparison)} compared, {comparison.group.steps:,} training steps per run"),
        *(Text(mixture.text, style="bold") for mixture in comparison.measured.mixtures),
        Text(),
        Text(headline.robot),
        Text(f"The {comparison.group.subject}: {word_of(headline.answer)}", style="bold"),
    ]
    lines = (*beside_answer(comparison), basis_text(comparison), advice(results, comparison))
    parts += [Text(line) for line in lines if line]
    for title, told in ((PAY, comparison.pay_sentence), (INDICES, comparison.index_sentence)):
        parts += [Text(f"\n{title}", style="bold"), Text(told)] if told else []
    parts.append(Text(f"\n{claims_text(comparison)}"))
    grids = [*behaviour_grids(comparison), along_grid(comparison), *number_grids(comparison, results.kind)]
    for grid in (*grids, *map(terms_grid, terms_of(results, comparison))):
        parts += show_grid(grid)
    return Group(*parts, Text())
