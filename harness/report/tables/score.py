"""Every training under every ruler, as a terminal shows it."""

from collections.abc import Sequence

from rich.console import Group, RenderableType

from harness.eta.index import NOTHING
from harness.report.rows import Grid
from harness.report.rows.comparison import SHOWN
from harness.report.tables.grid import show_titled
from harness.results.score_matrix import ScoreMatrix
from harness.text import shortened


def score_table(matrices: Sequence[ScoreMatrix]) -> RenderableType:
    """What ``harness score`` prints of an experiment: I_N and I_P of each group of cells."""
    return Group(*(show_titled(it.group.title, *(_grid(name, it) for name in ("I_N", "I_P"))) for it in matrices))


def _grid(name: str, matrix: ScoreMatrix) -> Grid:
    """A row per scoring reward and a column per training."""
    rows = [
        (scoring, *(f"{getattr(row[it], name):,.1f}" if it in row else NOTHING for it in matrix.seeds))
        for scoring, row in matrix.indices.items()
    ]
    failed = {it: f"n/a ({shortened(why, SHOWN)})" for it, why in matrix.failed.items() if it not in matrix.indices}
    rows += [(scoring, told, *[NOTHING] * (len(matrix.seeds) - 1)) for scoring, told in failed.items()]
    return Grid((f"{name}, scored by \\ trained on", *matrix.seeds), rows, [])
