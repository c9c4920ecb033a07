"""What an experiment says, as a terminal shows it."""

from rich import box
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from harness.report.return_rows import EXPLANATION, return_grids, return_title
from harness.report.rows import (
    NO_REWARD,
    PATHS,
    SCALES,
    SPLIT,
    Grid,
    behaviour_grid,
    combination_title,
    corrected_text,
    count_cells,
    index_grid,
    is_split,
    ratio_grid,
    rewards_text,
    seeds_text,
    split_grid,
    unfinished_cells,
)
from harness.results import Results
from harness.results.combination import Combination
from harness.results.return_matrix import ReturnMatrix, return_matrices


def comparison_table(results: Results) -> RenderableType:
    """What ``harness run`` and ``harness report`` print at the end: a block per combination, then the cells."""
    combinations = results.combinations
    blocks = [_combination_block(combination, len(combinations)) for combination in combinations]
    if any(combination.seeds for combination in combinations):
        told = [SCALES, *([SPLIT, PATHS] if any(map(is_split, combinations)) else []), NO_REWARD]
        blocks.append(Text(" ".join(told) + "\n"))
    matrices = return_matrices(results)
    if matrices:
        blocks += [*map(_return_block, matrices), Text(EXPLANATION + "\n")]
    blocks.append(Text(count_cells(results), style="bold"))
    return Group(*blocks, *map(Text, unfinished_cells(results)))


def _combination_block(combination: Combination, combinations: int) -> RenderableType:
    """The verdict first, then what it rests on."""
    parts: list[RenderableType] = [
        Text(combination_title(combination), style="bold"),
        Text(rewards_text(combination)),
        Text(f"{seeds_text(combination.seeds)} compared, {combination.group.steps:,} training steps per run"),
        Text(f"policies evaluated {combination.group.manner}\n"),
        Text(combination.verdict, style="bold"),
    ]
    corrected = corrected_text(combination, combinations)
    parts += [Text(line) for line in (combination.basis, corrected) if line]
    for make_grid in (ratio_grid, split_grid, index_grid, behaviour_grid):
        parts += show_grid(make_grid(combination))
    return Group(*parts, Text())


def _return_block(matrix: ReturnMatrix) -> RenderableType:
    """Every training under every reward."""
    parts = [part for grid in return_grids(matrix) for part in show_grid(grid)]
    return Group(Text(return_title(matrix), style="bold"), *parts, Text())


def show_grid(grid: Grid) -> list[RenderableType]:
    """The grid with its notes, an empty line before it; nothing if it is empty."""
    parts: list[RenderableType] = [_table(grid)] if grid.rows else []
    parts += map(Text, grid.notes)
    return [Text(), *parts] if parts else []


def _table(grid: Grid) -> Table:
    """Names to the left, which may wrap; values to the right, which may not."""
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 1, 0, 0))
    for position, heading in enumerate(grid.headings):
        if position:
            table.add_column(Text(heading), justify="right", no_wrap=True)
        else:
            table.add_column(Text(heading), overflow="fold")
    for row in grid.rows:
        table.add_row(*map(Text, row))  # Text, not str: "[m]" is no markup
    return table
