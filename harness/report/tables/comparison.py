"""The comparisons of an experiment, as a terminal shows them."""

from rich.console import Group, RenderableType
from rich.text import Text

from harness.report.rows.comparison import (
    NO_REWARD,
    advice,
    along_grid,
    basis_text,
    behaviour_grids,
    beside_answer,
    claims_text,
    compared_text,
    count_cells,
    remarks_on_cells,
    rewards_text,
    what_decides,
    word_of,
)
from harness.report.rows.ratios import SPLIT, scales_text
from harness.report.rows.returns import (
    EXPLANATION,
    INDICES,
    PAY,
    READING,
    matrix_title,
    number_grids,
    return_grid,
    terms_grid,
    terms_of,
)
from harness.report.tables.grid import alone_lines, interim_lines, pooled_lines, said_lines, show_grid, show_titled
from harness.results import Results
from harness.results.comparison import Comparison


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
