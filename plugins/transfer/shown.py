"""Transfer between simulators as facts of a report."""

from collections.abc import Iterator

from harness.eta.headline import estimate_text, format_number, percentage, points
from harness.report.rows.ratios import lines_of, value_rows
from harness.results import Fact, Grid

from .matrix import TransferMatrix, Transfers

TITLE = "Transfer between simulators"
EXPLANATION = (
    "Policies that were trained in one simulator are evaluated in another, with the same task, robot, reward, starts "
    "and targets. Numbers are means over seeds, with 95% intervals over seeds. The drop is success where they were "
    "trained minus success here, for the same seeds, in percentage points."
)


def transfer_facts(transfers: Transfers) -> tuple[Fact, ...]:
    """A table for each algorithm and reward, then a line for each evaluation that failed or is damaged."""
    failed = (f"{it.status}: {cell.title} in {it.simulator.label}: {it.reason}" for cell, it in transfers.failed)
    tables = (Fact(it.group.title, grids=(transfer_grid(it),)) for it in transfers.matrices)
    return (Fact(TITLE, (EXPLANATION,)), *tables, Fact(lines=tuple(failed)))


def transfer_grid(matrix: TransferMatrix) -> Grid:
    """A row for each simulator trained in, and below the table the largest drop of each in words."""
    headings = ("trained in \\ evaluated in", *matrix.evaluated_in)
    count = len(matrix.trained_in)
    rows = [line for row in range(count) for line in _lines(matrix, row)]
    drops = [_largest_drop(matrix, row) for row in range(count)]
    remarks = (
        (f"{home} in {place}", note)
        for home, row in zip(matrix.trained_in, matrix.success, strict=True)
        for place, mean in zip(matrix.evaluated_in, row, strict=True)
        for note in mean.notes
    )
    return Grid(headings, rows, [*drops, *lines_of(remarks, count * len(matrix.evaluated_in))])


def _lines(matrix: TransferMatrix, row: int) -> Iterator[tuple[str, ...]]:
    """The lines of a row: an interval stands under its mean. A line without any value is left out."""
    home = matrix.trained_in[row]
    for name, grid, text in (
        (f"{home}: success", matrix.success, percentage),
        ("  drop", matrix.drop, lambda drop: "" if drop is None else points(drop)),
        ("  return", matrix.paid, format_number),
    ):
        yield from (it for it in value_rows(name, grid[row], text, with_points=True) if any(it[1:]))


def _largest_drop(matrix: TransferMatrix, row: int) -> str:
    """The largest loss of success of the policies of one simulator."""
    drops = zip(matrix.evaluated_in, matrix.drop[row], strict=True)
    known = {place: drop for place, drop in drops if drop.value is not None}
    home = matrix.trained_in[row]
    if not known:
        return f"Trained in {home}: not evaluated anywhere else."
    place = max(known, key=lambda place: known[place].value or 0.0)
    told = estimate_text(known[place], points)
    return f"Trained in {home}: the largest drop of success is {told} points, in {place}."
