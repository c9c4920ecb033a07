"""Every training under every ruler, as a terminal shows it."""

from collections.abc import Mapping, Sequence

from rich.console import Group, RenderableType
from rich.text import Text

from harness.eta.index import NOTHING
from harness.report.rows.behaviour import SHOWN
from harness.report.rows.ratios import Grid
from harness.report.tables.grid import show_grid
from harness.results.score_matrix import ScoreMatrix
from harness.text import shortened


def score_table(matrices: Sequence[ScoreMatrix]) -> RenderableType:
    """What ``harness score`` prints of an experiment: I_N and I_P of each group of cells."""
    return Group(*map(_block, matrices))


def score_grids(matrix: ScoreMatrix) -> list[Grid]:
    """A grid for I_N and one for I_P, with a row per scoring reward and a column per training."""
    negative = {scoring: {name: index.I_N for name, index in row.items()} for scoring, row in matrix.indices.items()}
    positive = {scoring: {name: index.I_P for name, index in row.items()} for scoring, row in matrix.indices.items()}
    return [_grid("I_N", matrix, negative), _grid("I_P", matrix, positive)]


def _grid(name: str, matrix: ScoreMatrix, sums: Mapping[str, Mapping[str, float]]) -> Grid:
    rows = [
        (scoring, *(f"{row[training]:,.1f}" if training in row else NOTHING for training in matrix.seeds))
        for scoring, row in sums.items()
    ]
    failed = {
        scoring: f"n/a ({shortened(why, SHOWN)})" for scoring, why in matrix.failed.items() if scoring not in sums
    }
    rows += [(scoring, told, *[NOTHING] * (len(matrix.seeds) - 1)) for scoring, told in failed.items()]
    return Grid((f"{name}, scored by \\ trained on", *matrix.seeds), rows, [])


def _block(matrix: ScoreMatrix) -> RenderableType:
    parts = [part for grid in score_grids(matrix) for part in show_grid(grid)]
    return Group(Text(matrix.group.title, style="bold"), *parts, Text())
