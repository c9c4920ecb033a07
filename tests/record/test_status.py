"""How far an experiment has come."""

import shutil

import pytest

from harness.record import MANIFEST, Store
from harness.record.cell import Running, write_running
from harness.record.status import read_status


@pytest.fixture
def store(ran):
    """Of the experiment."""
    return Store.open(ran)


@pytest.fixture
def gone(store):
    """Its cells, of which those at these places are taken away, and the last of them is told to be running."""

    def gone(*places):
        cells = store.read_plan().cells
        for place in places:
            shutil.rmtree(store.cell_folder(cells[place]))
        write_running(store.folder, {cells[places[-1]].id: Running(100.0, 6, 103.0)})
        return cells

    return gone


def test_every_cell_has_its_status(ran, store, gone):
    """One is done, one is pending, one is damaged, one is running."""
    (store.cell_folder(gone(1, 3)[2]) / MANIFEST).write_text("{")
    with store.locked():
        found = read_status(ran, lambda: 104.0)
    assert found.is_in_use
    assert [one.status for one in found.cells] == ["done", "pending", "damaged", "running"]


def test_a_killed_run_leaves_interrupted_cells(ran, gone):
    """Nobody holds the folder: what was running is not."""
    gone(0)
    found = read_status(ran)
    assert not found.is_in_use
    assert found.cells[0].status == "interrupted"
    assert found.seconds_left is None


def test_the_rest_takes_what_the_cells_take(ran, store, gone):
    """The speed of who is running, and besides the training what the done cells took."""
    gone(3, 2)
    with store.locked():
        found = read_status(ran, lambda: 104.0)
    done = [it.took for it in found.cells if it.took]
    besides = sum(it.seconds - it.training_seconds for it in done) / 2
    whole = sum(it.training_seconds for it in done) / 2 + besides
    assert found.seconds_left == pytest.approx(6 * 0.5 + besides + whole)
