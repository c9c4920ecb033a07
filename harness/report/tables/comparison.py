"""The comparisons of an experiment, as a terminal shows them."""

from rich.console import Group, RenderableType
from rich.text import Text

from harness.report.rows.behaviour import along_grid, behaviour_grids
from harness.report.rows.comparison import (
    NO_REWARD,
    SCALES,
    SPLIT,
    TESTS,
    advice,
    answer_text,
    claims_text,
    count_cells,
    index_grid,
    ratio_grid,
    remarks_on_cells,
    rewards_text,
    seeds_text,
    split_grid,
    sum_grid,
)
from harness.report.rows.returns import EXPLANATION, return_grid
from harness.report.tables.grid import show_grid
from harness.results import Results
from harness.results.comparison import Comparison
from harness.results.return_matrix import ReturnMatrix, return_matrices


def comparison_table(results: Results) -> RenderableType:
    """What ``harness run`` and ``harness report`` print at the end: a block per combination, then the cells."""
    combinations = results.combinations
    blocks = [_combination_block(results, combination) for combination in combinations]
    if any(combination.seeds for combination in combinations):
        is_split = any(combination.is_split for combination in combinations)
        told = [SCALES, *([SPLIT] if is_split else []), NO_REWARD, TESTS]
        blocks.append(Text(" ".join(told) + "\n"))
    matrices = return_matrices(results)
    if matrices:
        blocks += [*map(_return_block, matrices), Text(EXPLANATION + "\n")]
    blocks.append(Text(count_cells(results), style="bold"))
    return Group(*blocks, *map(Text, remarks_on_cells(results)))


def _combination_block(results: Results, combination: Comparison) -> RenderableType:
    """The two answers first, then what they rest on. The page shows more, which would fill many screens here."""
    headline, decomposition = combination.headline, combination.decomposition
    parts: list[RenderableType] = [
        Text(combination.group.title, style="bold"),
        Text(rewards_text(combination)),
        Text(f"{seeds_text(combination.seeds)} compared, {combination.group.steps:,} training steps per run"),
        *(Text(mixture.text, style="bold") for mixture in combination.mixtures),
        Text(),
        Text(f"The robot: {answer_text(headline)}", style="bold"),
        Text(headline.robot),
    ]
    more = advice(results, combination)
    parts += [Text(more)] if more else []
    parts += [Text("\nThe number", style="bold"), Text(headline.number)] if headline.number else []
    parts.append(Text(f"\n{claims_text(combination)}"))
    splits = combination.splits
    grids = [
        *behaviour_grids(combination)[:1],
        along_grid(combination),
        ratio_grid(splits),
        split_grid(splits),
        sum_grid(decomposition.total if decomposition else None),
        index_grid(decomposition, results.kind),
    ]
    for grid in grids:
        parts += show_grid(grid)
    return Group(*parts, Text())


def _return_block(matrix: ReturnMatrix) -> RenderableType:
    """Every training under every reward."""
    return Group(Text(matrix.group.title, style="bold"), *show_grid(return_grid(matrix)), Text())
