"""What an experiment says, as a terminal shows it."""

from rich.console import Group, RenderableType
from rich.text import Text

from harness.report.grid_table import show_grid
from harness.report.return_rows import EXPLANATION, return_grid
from harness.report.rows import (
    NO_REWARD,
    PATHS,
    SCALES,
    SPLIT,
    behaviour_grid,
    corrected_text,
    count_cells,
    index_grid,
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
        is_split = any(combination.is_split for combination in combinations)
        told = [SCALES, *([SPLIT, PATHS] if is_split else []), NO_REWARD]
        blocks.append(Text(" ".join(told) + "\n"))
    matrices = return_matrices(results)
    if matrices:
        blocks += [*map(_return_block, matrices), Text(EXPLANATION + "\n")]
    blocks.append(Text(count_cells(results), style="bold"))
    return Group(*blocks, *map(Text, unfinished_cells(results)))


def _combination_block(combination: Combination, combinations: int) -> RenderableType:
    """The verdict first, then what it rests on."""
    parts: list[RenderableType] = [
        Text(combination.group.title, style="bold"),
        Text(rewards_text(combination)),
        Text(f"{seeds_text(combination.seeds)} compared, {combination.group.steps:,} training steps per run"),
        Text(f"policies evaluated {combination.group.manner}\n"),
        Text(combination.verdict, style="bold"),
    ]
    corrected = corrected_text(combination, combinations)
    parts += [Text(line) for line in (combination.basis, corrected) if line]
    splits = combination.splits
    grids = (ratio_grid(splits), split_grid(splits), index_grid(combination.decomposition), behaviour_grid(combination))
    for grid in grids:
        parts += show_grid(grid)
    return Group(*parts, Text())


def _return_block(matrix: ReturnMatrix) -> RenderableType:
    """Every training under every reward."""
    return Group(Text(matrix.group.title, style="bold"), *show_grid(return_grid(matrix)), Text())
