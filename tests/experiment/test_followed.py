"""What happens to cells is written down as it happens."""

import pytest

from harness.executor import Event
from harness.experiment.followed import WRITE_EVERY, EndedCells, Followed, Trackers, Tracking
from harness.record import Store
from harness.record.cell import read_running
from tests.stores import create_store


class Times:
    """The time, set by hand."""

    now = 1000.0

    def __call__(self):
        """The time."""
        return self.now


@pytest.fixture
def followed(make_cell, make_plan, toys, tmp_path):
    """Of an experiment with one cell, the cell, the clock, and what is passed on."""
    cell, events, times = make_cell(), [], Times()
    plan = make_plan(cell)
    store = create_store(tmp_path / "out", plan)
    tracking = Tracking(Trackers({}, events.append), store.folder)
    return Followed(store, EndedCells(store, toys), tracking, events.append, now=times), cell, times, events


def test_running_cells_are_told_now_and_then(followed, tmp_path):
    """A start at once, steps every other second."""
    follow, cell, times, _ = followed
    follow(Event("started", cell))
    assert read_running(tmp_path / "out")[cell.id].steps == 0
    follow(Event("progress", cell, steps=4))
    assert read_running(tmp_path / "out")[cell.id].steps == 0
    times.now += WRITE_EVERY
    follow(Event("progress", cell, steps=8))
    assert read_running(tmp_path / "out")[cell.id].steps == 8


def test_a_cell_without_a_folder_gets_a_manifest(followed, tmp_path):
    """With the executor's reason; it counts as failed, and is not running any more."""
    follow, cell, _, events = followed
    follow(Event("started", cell))
    follow(Event("ended", cell, reason="its process was ended by SIGKILL"))
    assert Store(tmp_path / "out").examine(cell).reason == "its process was ended by SIGKILL"
    assert follow.failed == [cell]
    assert read_running(tmp_path / "out") == {}
    assert [event.kind for event in events] == ["started", "ended"]


def test_nothing_is_left_when_nothing_runs(followed, tmp_path):
    """The account of running cells goes with the run."""
    follow, cell, _, _ = followed
    follow(Event("started", cell))
    follow.stop()
    assert not (tmp_path / "out" / "running.json").exists()
