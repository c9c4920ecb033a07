"""Policies trained in one simulator, evaluated in others."""

from typing import TYPE_CHECKING, Any

from harness.face import look_up

if TYPE_CHECKING:
    from .jobs import plan_transfers, run_transfers, transfer
    from .matrix import load_transfers
    from .record import TRANSFER, TransferRecord, read_transfer, simulator_id

__all__ = [
    "TRANSFER",
    "TransferRecord",
    "load_transfers",
    "plan_transfers",
    "read_transfer",
    "run_transfers",
    "simulator_id",
    "transfer",
]

_HOMES = {
    "jobs": "plan_transfers run_transfers transfer",
    "matrix": "load_transfers",
    "record": "TRANSFER TransferRecord read_transfer simulator_id",
}


def __getattr__(name: str) -> Any:
    return look_up(__name__, _HOMES, name)
