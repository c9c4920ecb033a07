"""Transfer between simulators as text: what the terminal and the page share."""

from collections.abc import Callable, Iterable
from typing import NamedTuple

from rich.console import Group, RenderableType
from rich.text import Text

from harness.eta import SeedMean
from harness.eta.index import NOTHING
from harness.report import Grid, format_number
from harness.report.tables.grid import show_grid

from .matrix import Failure, TransferMatrix, Transfers

TITLE = "Transfer between simulators"
HOME = "*"
EXPLANATION = (
    "Policies that were trained in one simulator are evaluated in another, with the same task, robot, reward, starts "
    "and targets. Numbers are means over seeds, with 95% intervals over seeds. The drop is success where they were "
    "trained minus success here, for the same seeds."
)


class TransferCell(NamedTuple):
    """The policies that one simulator trained, evaluated in one simulator, ready to print."""

    success: str
    success_interval: str
    drop: str
    """The drop in success; empty in the simulator in which the policies were trained."""
    drop_interval: str
    paid: str
    paid_interval: str
    share: float
    """The success as a number in [0, 1], for its colour; 0 if there is none."""
    home: bool
    """Whether the policies were trained there."""
    is_known: bool
    """Whether the success is known."""


class TransferRow(NamedTuple):
    """The policies of one simulator."""

    trained_in: str
    cells: tuple[TransferCell, ...]


class TransferBlock(NamedTuple):
    """One algorithm and reward, ready to print."""

    title: str
    evaluated_in: tuple[str, ...]
    rows: tuple[TransferRow, ...]
    summary: tuple[str, ...]
    """The largest drop of each row, in words."""
    notes: tuple[str, ...]


def transfer_block(matrix: TransferMatrix) -> TransferBlock:
    """A matrix as text."""
    return TransferBlock(
        matrix.group.title,
        matrix.evaluated_in,
        tuple(
            TransferRow(home, tuple(_cell(matrix, row, column) for column in range(len(matrix.evaluated_in))))
            for row, home in enumerate(matrix.trained_in)
        ),
        tuple(_largest_drop(matrix, row) for row in range(len(matrix.trained_in))),
        tuple(_notes(matrix)),
    )


def transfer_grid(block: TransferBlock) -> Grid:
    """A block as a table for a terminal, with the summary below it."""
    headings = ("trained in \\ evaluated in", *block.evaluated_in)
    return Grid(headings, [line for row in block.rows for line in _lines(row)], [*block.summary, *block.notes])


def failure_lines(failed: Iterable[Failure]) -> list[str]:
    """A line for each evaluation that failed or is damaged."""
    return [f"{record.status}: {cell.title} in {record.simulator.label}: {record.reason}" for cell, record in failed]


def _lines(row: TransferRow) -> list[tuple[str, ...]]:
    """The lines of a row: an interval stands under its mean. Without any interval there is one line."""
    cells = row.cells
    lines = [
        (f"{row.trained_in}: success", [f"{cell.success} {HOME if cell.home else ' '}" for cell in cells]),
        ("  95% interval", [f"{cell.success_interval}  " for cell in cells]),
        ("  drop", [f"{cell.drop}  " for cell in cells]),
        ("  95% interval", [f"{cell.drop_interval}  " for cell in cells]),
        ("  return", [f"{cell.paid}  " for cell in cells]),
        ("  95% interval", [f"{cell.paid_interval}  " for cell in cells]),
    ]
    return [(name, *values) for name, values in lines if any(value.strip() for value in values)]


def _cell(matrix: TransferMatrix, row: int, column: int) -> TransferCell:
    success, paid, drop = (grid[row][column] for grid in (matrix.success, matrix.paid, matrix.drop))
    home = matrix.trained_in[row] == matrix.evaluated_in[column]
    return TransferCell(
        NOTHING if success.mean is None else f"{success.mean:.1%}",
        _interval(success, _percent),
        _drop_text(drop),
        _interval(drop, _percent),
        format_number(paid.mean),
        _interval(paid, format_number),
        success.mean or 0.0,
        home,
        success.mean is not None,
    )


def _largest_drop(matrix: TransferMatrix, row: int) -> str:
    """The largest loss of success of the policies of one simulator."""
    drops = zip(matrix.evaluated_in, matrix.drop[row], strict=True)
    known = {place: drop for place, drop in drops if drop.mean is not None}
    home = matrix.trained_in[row]
    if not known:
        return f"Trained in {home}: not evaluated anywhere else."
    place = max(known, key=lambda place: known[place].mean or 0.0)
    told = " ".join(part for part in (_drop_text(known[place]), _interval(known[place], _percent)) if part)
    return f"Trained in {home}: the largest drop of success is {told}, in {place}."


def _notes(matrix: TransferMatrix) -> list[str]:
    """One line for each remark, with the places that it holds for."""
    where: dict[str, list[str]] = {}
    for home, row in zip(matrix.trained_in, matrix.success, strict=True):
        for place, mean in zip(matrix.evaluated_in, row, strict=True):
            for note in mean.notes:
                where.setdefault(note, []).append(f"{home} in {place}")
    everywhere = len(matrix.trained_in) * len(matrix.evaluated_in)
    return [note if len(places) == everywhere else f"{', '.join(places)}: {note}" for note, places in where.items()]


def _drop_text(drop: SeedMean) -> str:
    """A drop in percentage points."""
    return "" if drop.mean is None else f"{_percent(drop.mean)} pp"


def _interval(mean: SeedMean, text: Callable[[float], str]) -> str:
    if mean.low is None or mean.high is None:
        return ""
    return f"[{text(mean.low)}, {text(mean.high)}]"


def _percent(share: float) -> str:
    return f"{round(100 * share, 1) + 0.0:.1f}"  # no -0.0


def transfer_table(transfers: Transfers) -> RenderableType:
    """A block per algorithm and reward, then what failed."""
    blocks = [_show(transfer_block(matrix)) for matrix in transfers.matrices]
    failed = map(Text, failure_lines(transfers.failed))
    return Group(Text(TITLE, style="bold"), Text(f"{EXPLANATION} {HOME} trained there.\n"), *blocks, *failed)


def _show(block: TransferBlock) -> RenderableType:
    return Group(Text(block.title, style="bold"), *show_grid(transfer_grid(block)), Text())
