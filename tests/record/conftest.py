"""A small experiment that really ran, with everything that a folder may hold."""

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from harness.experiment.draft import leave_record
from harness.experiment.plan import Plan
from harness.files.sums import note_made
from harness.record.cell import Cell
from harness.record.folder import EVALUATION, partial_folder
from harness.record.store import REPORT, Store
from harness.registry.choice import Choice
from harness.results import Results
from harness_plugins.transfer.record import TRANSFER, TransferRecord, simulator_id

ARP = Choice("arp", (("k1", 1.0), ("k2", 1.5)), "arp")


@pytest.fixture
def ran(
    make_cell: Callable[..., Cell],
    make_plan: Callable[..., Plan],
    run_here: Callable[..., Results],
    tmp_path: Path,
    tmp_path_factory: pytest.TempPathFactory,
) -> Path:
    """Two seeds of two rewards, all done; one policy was evaluated elsewhere; table and page were made."""
    kept = tmp_path_factory.getbasetemp() / "ran"
    if not kept.exists():
        _run(kept, make_cell, make_plan, run_here)
    return Path(shutil.copytree(kept, tmp_path / "ran"))


def _run(
    folder: Path,
    make_cell: Callable[..., Cell],
    make_plan: Callable[..., Plan],
    run_here: Callable[..., Results],
) -> None:
    cells = [make_cell(seed=seed, reward=reward) for seed in range(2) for reward in (make_cell().reward, ARP)]
    results = run_here(make_plan(*cells), folder)
    assert [manifest.status for manifest in results.manifests] == ["done"] * 4
    results.write_table()
    (folder / REPORT).write_text("<html></html>\n")
    note_made(folder / REPORT)
    elsewhere = Choice("kinematic", (), "kinematic")
    place = folder / TRANSFER / cells[0].id / simulator_id(elsewhere)
    partial_folder(place).mkdir(parents=True)
    shutil.copy(Store(folder).cell_folder(cells[0]) / EVALUATION, partial_folder(place) / EVALUATION)
    leave_record(place, TransferRecord(cells[0].id, elsewhere, "", status="done"))
