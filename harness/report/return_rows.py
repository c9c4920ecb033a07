"""Returns under every reward, as text."""

from collections.abc import Mapping, Sequence

from harness.eta.seed_mean import SeedMean
from harness.report.rows import NOTHING, Grid, format_number
from harness.results.return_matrix import ReturnMatrix

TITLE = "Return under every reward"
EXPLANATION = (
    "What each reward (a row) would pay the policies that each reward taught (a column): the shaped return of an "
    "evaluation episode, mean over episodes and seeds. Compare within a row: down a column the scale changes, not the "
    "behaviour."
)
SCORED_BY = "evaluation return, scored by"
COLUMNS = 3
"""Trainings side by side in a terminal."""


def return_title(matrix: ReturnMatrix) -> str:
    """Where it was: simulator, algorithm, robot and task."""
    group = matrix.group
    return " · ".join([group.simulator.label, group.algorithm.label, group.robot, group.task.label])


def return_grids(matrix: ReturnMatrix, columns: int = COLUMNS) -> list[Grid]:
    """The matrix in pieces of so many trainings, each interval under its mean; notes below the last piece."""
    starts = range(0, len(matrix.trained_with), columns)
    grids = [_grid(matrix, matrix.trained_with[start : start + columns]) for start in starts]
    return [*grids[:-1], grids[-1]._replace(notes=_notes(matrix))]


def _grid(matrix: ReturnMatrix, trainings: Sequence[str]) -> Grid:
    headings = (SCORED_BY, *trainings)
    rows: list[tuple[str, ...]] = []
    for name, row in _named(matrix).items():
        rows.append((name, *(format_number(row[label].mean) for label in trainings)))
        intervals = [_interval(row[label]) for label in trainings]
        if any(intervals):
            rows.append(("  95% interval", *intervals))
    return Grid(headings, rows, [])


def _named(matrix: ReturnMatrix) -> dict[str, Mapping[str, SeedMean]]:
    return {**matrix.returns, "events, paid on top": matrix.events}


def _notes(matrix: ReturnMatrix) -> list[str]:
    """One line for each thing to keep in mind, with the rows that it holds for if not for all."""
    where: dict[str, list[str]] = {}
    rows = _named(matrix)
    for name, row in rows.items():
        parts = dict.fromkeys(part for mean in row.values() for part in _parts(mean))
        for part in parts:
            where.setdefault(part, []).append(name)
    return [part if len(names) == len(rows) else f"{', '.join(names)}: {part}" for part, names in where.items()]


def _parts(mean: SeedMean) -> list[str]:
    if mean.mean is None and mean.note:
        return [f"{NOTHING}: {mean.note}"]
    return mean.note.split("; ") if mean.note else []


def _interval(mean: SeedMean) -> str:
    if mean.low is None or mean.high is None:
        return ""
    return f"[{format_number(mean.low)}, {format_number(mean.high)}]"
