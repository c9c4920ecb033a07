"""A small experiment that really ran, with everything that a folder may hold."""

import shutil
from pathlib import Path

import pytest

from harness.files import note_made
from harness.record import EVALUATION, REPORT, Store
from harness.registry import Choice
from harness_plugins.transfer import TransferRecord, simulator_id

ARP = Choice("arp", (("k1", 1.0), ("k2", 1.5)), "arp")


@pytest.fixture
def ran(make_cell, make_plan, run_here, tmp_path, tmp_path_factory):
    """Two seeds of two rewards, all done; one policy was evaluated elsewhere; table and page were made."""
    kept = tmp_path_factory.getbasetemp() / "ran"
    if not kept.exists():
        _run(kept, make_cell, make_plan, run_here)
    return Path(shutil.copytree(kept, tmp_path / "ran"))


def _run(folder, make_cell, make_plan, run_here):
    cells = [make_cell(seed=seed, reward=reward) for seed in range(2) for reward in (make_cell().reward, ARP)]
    results = run_here(make_plan(*cells), folder)
    assert [manifest.status for manifest in results.manifests] == ["done"] * 4
    results.write_table()
    (folder / REPORT).write_text("<html></html>\n")
    note_made(folder / REPORT)
    elsewhere = Choice("kinematic", (), "kinematic")
    place = folder / "transfer" / cells[0].id / simulator_id(elsewhere)
    place.mkdir(parents=True)
    shutil.copy(Store(folder).cell_folder(cells[0]) / EVALUATION, place)
    TransferRecord(cells[0].id, elsewhere, "", status="done").write(place)
