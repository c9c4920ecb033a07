"""Transfer between simulators, as a terminal shows it."""

from rich.console import Group, RenderableType
from rich.text import Text

from harness.report.rows.transfer import (
    EXPLANATION,
    HOME,
    TITLE,
    TransferBlock,
    failure_lines,
    transfer_block,
    transfer_grid,
)
from harness.report.tables.grid import show_grid
from harness.transfer.matrix import Transfers


def transfer_table(transfers: Transfers) -> RenderableType:
    """A block per algorithm and reward, then what failed."""
    blocks = [_show(transfer_block(matrix)) for matrix in transfers.matrices]
    failed = map(Text, failure_lines(transfers.failed))
    return Group(Text(TITLE, style="bold"), Text(f"{EXPLANATION} {HOME} trained there.\n"), *blocks, *failed)


def _show(block: TransferBlock) -> RenderableType:
    return Group(Text(block.title, style="bold"), *show_grid(transfer_grid(block)), Text())
