"""What every built-in executor does, found by the registry; those that need a cluster start one, in `make slow`."""

import os
import threading
import time

import psutil
import pytest

from harness.executor import Cell, CellOptions, Event, Job, Limits, run_job
from harness.record import LOG, partial_folder, read_manifest
from harness.record.cell import whole_cell
from harness.registry import choose

ELSEWHERE = ("ray", "ray:fetch=true", "slurm:cluster=local", "slurm:memory=0.5")


# submitit does not wait for the processes that it starts in Slurm's place.
pytestmark = pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")


@pytest.fixture(params=["processes", *(pytest.param(name, marks=pytest.mark.slow) for name in ELSEWHERE)])
def executor(request, toys):
    """Where its library is installed, and a cluster runs where it needs one."""
    name = request.param
    spec = toys.get("executors", name.partition(":")[0])
    if spec.missing:
        pytest.skip(f"{', '.join(spec.missing)} is not installed: {spec.remedy}")
    if "memory" in name:
        request.getfixturevalue("slurm")
    return choose(toys, "executors", name).build(toys, "executors")


def test_these_are_all(toys):
    """No built-in executor is left out; the toys have one of their own."""
    assert {*toys.names("executors")} == {"here", "processes", *(name.partition(":")[0] for name in ELSEWHERE)}


def test_cells_that_go_wrong_cost_themselves_alone(executor, that, make_cell, tmp_path):
    """Each begins and ends once, told in the caller's thread, at most two at once; others leave what `run_job` does."""
    good = [make_cell(seed=seed) for seed in range(2)]
    raising, killed = that("raise"), that("be killed")
    cells, told, threads = [good[0], raising, killed, good[1]], list[Event](), set[int]()

    def hear(event):
        told.append(event)
        threads.add(threading.get_ident())

    executor.run([], 2, hear)
    assert not told
    executor.run([Job(cell, tmp_path / cell.id) for cell in cells], 2, hear)
    assert threads == {threading.get_ident()}
    running, most = set[Cell](), 0
    for event in told:
        running = running - {event.cell} if event.kind == "ended" else running | {event.cell}
        most = max(most, len(running))
    assert most <= 2
    for cell in cells:
        first, *between, last = [event for event in told if event.cell == cell]
        assert (first.kind, {event.kind for event in between} - {"progress"}, last.kind) == ("started", set(), "ended")
        assert all(0 <= event.steps <= cell.steps for event in between)
        assert bool(last.reason) is (cell == killed)
    assert "the arm" in read_manifest(tmp_path / raising.id).reason
    assert (partial_folder(tmp_path / killed.id) / LOG).is_file()
    for cell in good:
        left, here = whole_cell(tmp_path / cell.id), run_job(Job(cell, tmp_path / "here" / cell.id))
        assert left.status == "done"
        assert not partial_folder(tmp_path / cell.id).exists()
        assert {**left.files, LOG: ""} == {**here.files, LOG: ""}


def test_a_cell_that_hangs_is_ended(executor, that, make_cell, tmp_path):
    """With the limit in its reason; its process is gone, and the other cell is done."""
    hung, good, told = that("wait", tmp_path / "pid"), make_cell(), list[Event]()
    limited = CellOptions(limits=Limits(stall_after=4.0))  # the other one's process alone may take as long to start
    executor.run([Job(hung, tmp_path / hung.id, limited), Job(good, tmp_path / good.id)], 1, told.append)
    reasons = {event.cell: event.reason for event in told if event.kind == "ended"}
    assert "4 s" in reasons[hung]
    assert reasons[good] == ""
    assert not psutil.pid_exists(int((tmp_path / "pid").read_text()))


def test_an_interruption_leaves_nothing_running(executor, that, tmp_path):
    """KeyboardInterrupt passes on, and the cell that was in the middle is gone within a moment."""
    notes = [tmp_path / "one", tmp_path / "two"]
    cells = [that("last", notes[0]), that("wait", notes[1])]

    def interrupt(event):
        if event.kind == "ended":
            assert wait_until(notes[1].exists)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        executor.run([Job(cell, tmp_path / cell.id) for cell in cells], 2, interrupt)
    pid = int(notes[1].read_text())
    assert pid != os.getpid()
    assert wait_until(lambda: not psutil.pid_exists(pid))


def wait_until(holds):
    """Whether it comes to hold within five seconds: a process may be on another machine."""
    until = time.monotonic() + 5.0
    while not holds() and time.monotonic() < until:
        time.sleep(0.05)
    return holds()
