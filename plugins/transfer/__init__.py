"""Policies trained in one simulator, evaluated in others."""

from typing import TYPE_CHECKING

from harness.face import face_of

if TYPE_CHECKING:
    from .jobs import plan_transfers as plan_transfers, run_transfers as run_transfers, transfer as transfer
    from .matrix import load_transfers as load_transfers
    from .record import (
        TRANSFER as TRANSFER,
        TransferRecord as TransferRecord,
        read_transfer as read_transfer,
        simulator_id as simulator_id,
    )
else:
    __all__, __getattr__ = face_of(__name__)
