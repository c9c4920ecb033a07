"""Returns under every reward, as text."""

from collections.abc import Mapping

from harness.eta.seed_mean import SeedMean
from harness.report.rows.comparison import Grid, format_number
from harness.results.overview import NOTHING
from harness.results.return_matrix import ReturnMatrix

TITLE = "Return under every reward"
EXPLANATION = (
    "What each reward (a row) would pay the policies that each reward taught (a column): the shaped return of an "
    "evaluation episode, mean over episodes and seeds. Compare within a row: down a column the scale changes, not the "
    "behaviour."
)
SCORED_BY = "evaluation return, scored by"


def return_grid(matrix: ReturnMatrix) -> Grid:
    """A row per scoring reward, each interval under its mean; a column per training."""
    rows: list[tuple[str, ...]] = []
    for name, row in _named(matrix).items():
        means = [row[label] for label in matrix.trained_with]
        rows.append((name, *(format_number(mean.mean) for mean in means)))
        if any(mean.low is not None for mean in means):
            rows.append(("  95% interval", *map(_interval, means)))
    return Grid((SCORED_BY, *matrix.trained_with), rows, _notes(matrix))


def _named(matrix: ReturnMatrix) -> dict[str, Mapping[str, SeedMean]]:
    return {**matrix.returns, "events, paid on top": matrix.events}


def _notes(matrix: ReturnMatrix) -> list[str]:
    """One line for each remark, with the rows that it holds for if not for all."""
    where: dict[str, list[str]] = {}
    rows = _named(matrix)
    for name, row in rows.items():
        parts = dict.fromkeys(part for mean in row.values() for part in _parts(mean))
        for part in parts:
            where.setdefault(part, []).append(name)
    return [part if len(names) == len(rows) else f"{', '.join(names)}: {part}" for part, names in where.items()]


def _parts(mean: SeedMean) -> list[str]:
    return [f"{NOTHING}: {note}" for note in mean.notes] if mean.mean is None else list(mean.notes)


def _interval(mean: SeedMean) -> str:
    if mean.low is None or mean.high is None:
        return ""
    return f"[{format_number(mean.low)}, {format_number(mean.high)}]"
