"""A cell that is timed from outside, in a process of its own."""

import time
from collections.abc import Callable
from pathlib import Path

import pytest

from harness.executor import Event
from harness.record.cell import Cell
from harness.registry.choice import Choice
from harness_plugins.bench.timed_cell import Failed, time_cell

pytestmark = pytest.mark.usefixtures("toys")
MakeCell = Callable[..., Cell]


def _that(make_cell: MakeCell, then: str) -> Cell:
    return make_cell(algorithm=Choice("wander", (("then", then),), f"wander:then={then}"))


def test_the_whole_is_the_life_of_the_process(make_cell: MakeCell, tmp_path: Path):
    """Its start and its end included, as somebody else measured it; nothing is left; the cell's events are told."""
    told: list[Event] = []
    begin = time.perf_counter()
    times = time_cell(make_cell(), tmp_path / "cell", told.append)
    passed = time.perf_counter() - begin
    assert times.whole == pytest.approx(passed, abs=0.1)
    assert times.whole <= passed
    assert min(times.seconds.values()) > 0.0
    assert times.seconds["start_up"] > 0.05  # no Python with numpy starts faster
    assert list(tmp_path.iterdir()) == []
    assert [told[0].kind, told[-1].kind, told[-2].steps, told[-1].reason] == ["started", "ended", 12, ""]


@pytest.mark.parametrize(
    ("then", "reason"),
    [
        ("raise", "RuntimeError: the arm fell off"),
        ("be killed", "its process was ended by SIGKILL"),
        ("_exit", "its process ended with exit status 3 before the cell did"),
    ],
)
def test_a_cell_that_fails_has_a_reason_for_times(make_cell: MakeCell, tmp_path: Path, then: str, reason: str):
    """It is told who looks on, too."""
    told: list[Event] = []
    assert time_cell(_that(make_cell, then), tmp_path / "cell", told.append) == Failed(reason)
    assert (told[-1].kind, told[-1].reason) == ("ended", reason)


def test_a_process_that_ends_before_it_tells_its_times(make_cell: MakeCell, tmp_path: Path, monkeypatch):
    """The cell is done, and yet there is nothing to show."""
    from harness.experiment.workers.workers import News
    from harness.record.folder import partial_folder
    from harness.record.manifest import Manifest

    def leave_no_times(orders, at_once, on_news):
        folder = orders[0].folder
        folder.mkdir()
        Manifest(make_cell(), status="done").write(folder)
        assert not partial_folder(folder).exists()
        on_news(News("ended", folder))

    monkeypatch.setattr("harness_plugins.bench.timed_cell.run_orders", leave_no_times)
    found = time_cell(make_cell(), tmp_path / "cell", lambda event: None)
    assert found == Failed("its process ended before it told its times")
