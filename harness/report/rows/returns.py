"""Returns under every reward, as text."""

from collections.abc import Iterator, Mapping

from harness.eta.index import NOTHING
from harness.eta.scored_sums import BB, KK
from harness.eta.seed_mean import SeedMean
from harness.report.rows.ratios import Grid, lines_of, value_rows
from harness.results.comparison import Comparison
from harness.results.return_matrix import ReturnMatrix

TITLE = "Return under every reward"
EXPLANATION = (
    "A row is a reward that pays, a column the reward that taught the policies. The number is the return of an "
    "episode, as a mean over episodes and seeds. Compare within a row: down a column the scale changes, not the "
    "behaviour."
)
SCORED_BY = "evaluation return, scored by"
PAY = "The pay of an episode"
READING = (
    "The pay of an episode is its return, as a mean over episodes, then over seeds. Each training is paid by its own "
    "reward, baseline or proposed. Its change has two parts. The ruler is rescaling alone: both rewards pay the same "
    "episodes. For the behaviour one reward pays the episodes of both."
)


def returns_grid(comparison: Comparison) -> Grid:
    """The pay of an episode of either training, and what its change is made of; no rows if it is not known."""
    rows: list[tuple[str, ...]] = []
    for manner, split in comparison.number.returns.items():
        parts = (split.total.change, split.total.ruler, split.total.behaviour)
        rows += value_rows(manner, (split.returns[BB], split.returns[KK], *parts), with_points=True)
    notes = [f"{manner}: {NOTHING}: {reason}" for manner, reason in comparison.number.missing.items()]
    reasons = dict.fromkeys(
        note
        for split in comparison.number.returns.values()
        for it in (split.returns[BB], split.total.ruler)
        for note in it.notes
    )
    headings = ("", "baseline", "proposed", "difference", "of it ruler", "of it behaviour")
    return Grid(headings, rows, [*notes, *reasons], PAY)


def return_grid(matrix: ReturnMatrix) -> Grid:
    """A row per scoring reward, each interval under its mean; a column per training."""
    rows: list[tuple[str, ...]] = []
    for name, row in _named(matrix).items():
        rows += value_rows(name, [row[label] for label in matrix.trained_with], with_points=True)
    scored = f"return {matrix.manner}, scored by" if matrix.manner else SCORED_BY
    return Grid((scored, *matrix.trained_with), rows, _notes(matrix))


def matrix_title(matrix: ReturnMatrix) -> str:
    """Which trainings a matrix is about."""
    return f"{matrix.group.title}, {matrix.manner}" if matrix.manner else matrix.group.title


def _named(matrix: ReturnMatrix) -> dict[str, Mapping[str, SeedMean]]:
    events = {"events, paid on top": matrix.events} if matrix.events else {}
    return {**matrix.returns, **events}


def _notes(matrix: ReturnMatrix) -> list[str]:
    """One line for each remark, with the rows that it holds for if not for all."""
    rows = _named(matrix)
    return lines_of(((name, note) for name, row in rows.items() for note in dict.fromkeys(_notes_of(row))), len(rows))


def _notes_of(row: Mapping[str, SeedMean]) -> Iterator[str]:
    for mean in row.values():
        yield from (f"{NOTHING}: {note}" if mean.mean is None else note for note in mean.notes)
