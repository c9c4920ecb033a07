"""How far an experiment has come."""

import shutil

import pytest

from harness.record import MANIFEST, Store
from harness.record.running import Running, write_running
from harness.record.status import read_status


def test_every_cell_has_its_status(ran):
    """One is done, one is pending, one is damaged, one is running."""
    store = Store.open(ran)
    _, pending, damaged, running = store.read_plan().cells
    shutil.rmtree(store.cell_folder(pending))
    (store.cell_folder(damaged) / MANIFEST).write_text("{")
    shutil.rmtree(store.cell_folder(running))
    write_running(ran, {running.id: Running(100.0, 6, 103.0)})
    with store.locked():
        found = read_status(ran, lambda: 104.0)
    assert found.is_in_use
    assert [one.status for one in found.cells] == ["done", "pending", "damaged", "running"]


def test_a_killed_run_leaves_interrupted_cells(ran):
    """Nobody holds the folder: what was running is not."""
    store = Store.open(ran)
    cell = store.read_plan().cells[0]
    shutil.rmtree(store.cell_folder(cell))
    write_running(ran, {cell.id: Running(100.0, 6, 103.0)})
    found = read_status(ran)
    assert not found.is_in_use
    assert found.cells[0].status == "interrupted"
    assert found.seconds_left is None


def test_the_rest_takes_what_the_cells_take(ran):
    """The speed of who is running, and besides the training what the done cells took."""
    store = Store.open(ran)
    cells = store.read_plan().cells
    for cell in cells[3:]:
        shutil.rmtree(store.cell_folder(cell))
    shutil.rmtree(store.cell_folder(cells[2]))
    write_running(ran, {cells[2].id: Running(100.0, 6, 103.0)})
    with store.locked():
        found = read_status(ran, lambda: 104.0)
    done = [it.took for it in found.cells if it.took]
    besides = sum(it.besides for it in done) / 2
    whole = sum(it.training for it in done) / 2 + besides
    assert found.seconds_left == pytest.approx(6 * 0.5 + besides + whole)
