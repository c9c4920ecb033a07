"""Experiments as reports are tried with, and what `harness transfer` adds to one."""

from dataclasses import replace

import numpy as np
import pytest

from harness.policy import SquashedGaussian
from harness.record import EVALUATION, POLICY
from harness.registry import Choice
from harness_plugins.transfer import TRANSFER, TransferRecord, simulator_id
from harness_plugins.transfer.record import policy_digest
from tests.report.conftest import build

__all__ = ["build"]


def add_transfers(results):
    """Its policies were also in pybullet, where one evaluation failed."""
    for cell in results.done_cells:
        home = results.store.cell_folder(cell)
        weights = {f"{layer}.{part}": np.ones((1, 1), np.float32) for layer in ("mean", "log_std") for part in "wb"}
        weights["mean.weight"] = np.ones((1, 1), np.float32)
        SquashedGaussian(weights, "relu", (-1.0,), (1.0,)).save(home / POLICY)
        away = Choice("pybullet", (), "pybullet")
        folder = results.folder / TRANSFER / cell.id / simulator_id(away)
        folder.mkdir(parents=True)
        record = TransferRecord(cell.id, away, policy_digest(home), status="done")
        if (cell.reward.label, cell.seed) == ("arp", 1):
            record = replace(record, status="failed", reason="it <b>fell</b>")
        else:
            (folder / EVALUATION).write_bytes((home / "random.parquet").read_bytes())
        record.write(folder)


@pytest.fixture
def transferred(build):
    """An experiment whose policies were also in another simulator."""
    results = build()
    add_transfers(results)
    return results
