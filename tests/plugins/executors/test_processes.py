"""Cells in processes of their own: whatever one of them does, it costs that one alone."""

import json
import os
import re
import select
import subprocess
import sys

import pytest

from harness.executor import CellOptions, Job, Limits
from harness.experiment.run_cell import TrainCell
from harness.experiment.workers.order import Order
from harness.record import LOG, partial_folder, read_manifest
from harness_plugins.executors.processes import Processes

pytestmark = pytest.mark.usefixtures("toys")

DEFAULTS = CellOptions()


def _run(cells, folder, at_once=1, options=DEFAULTS):
    """The last event of each cell, by id."""
    events = []
    Processes().run([Job(cell, folder / cell.id, options) for cell in cells], at_once, events.append)
    assert [event.cell for event in events if event.kind == "ended"].count(cells[0]) == 1
    return {event.cell.id: event for event in events}


def test_every_cell_starts_progresses_and_ends(make_cell, tmp_path):
    """`on_event` hears of the start, each number of steps, with numbers at the last, and the end, in order."""
    cell, events = make_cell(steps=3), []
    Processes().run([Job(cell, tmp_path / "cell")], 1, events.append)
    assert [(event.kind, event.steps) for event in events] == [
        ("started", 0),
        ("progress", 0),
        ("progress", 1),
        ("progress", 2),
        ("progress", 3),
        ("progress", 3),
        ("ended", 0),
    ]
    assert [event.scalars != {} for event in events] == [False] * 5 + [True, False]
    assert read_manifest(tmp_path / "cell").status == "done"


def test_two_at_once(make_cell, tmp_path):
    """With `at_once` 2 the second cell starts before the first one ends, the third after."""
    cells, events = [make_cell(seed=seed) for seed in range(3)], []
    Processes().run([Job(cell, tmp_path / cell.id) for cell in cells], 2, events.append)
    kinds = [event.kind for event in events if event.kind != "progress"]
    assert kinds[:3] == ["started", "started", "ended"]
    assert kinds.count("ended") == 3


@pytest.mark.parametrize("then", ["raise", "sys.exit"])
def test_cell_that_raises_is_a_failed_cell(that, tmp_path, then):
    """The worker itself leaves the manifest, so the executor has no reason to add."""
    cell = that(then)
    assert _run([cell], tmp_path)[cell.id].reason == ""
    assert read_manifest(tmp_path / cell.id).status == "failed"


def test_killed_cells_cost_themselves_alone(that, make_cell, tmp_path, monkeypatch):
    """A signal, an exit and a silent exit are told apart in the reason; the cell after them is done."""
    monkeypatch.delenv("PYTHONUNBUFFERED", raising=False)  # with it, nothing printed could get lost
    killed, left, silent = (that(then) for then in ("be killed", "_exit", "die silently"))
    good = make_cell()
    last = _run([killed, left, silent, good], tmp_path, at_once=2)
    assert last[killed.id].reason == "its process was ended by SIGKILL"
    assert last[left.id].reason == "its process ended with exit status 3 before the cell did"
    assert last[silent.id].reason == "its process ended with exit status 0 before the cell did"
    assert last[good.id].reason == ""
    assert read_manifest(tmp_path / good.id).status == "done"
    # What was printed before the death is in the log that the failed cell keeps.
    assert (partial_folder(tmp_path / silent.id) / LOG).read_text().endswith("last words\n")


def test_output_of_plugins_lands_in_the_log(that, tmp_path):
    """Whatever way a plugin or its child prints, it is in log.txt, in order, and disturbs no progress."""
    cell = that("chat")
    assert _run([cell], tmp_path)[cell.id].reason == ""
    text = (tmp_path / cell.id / LOG).read_text()
    assert text.endswith("by print\nby standard error\nby the file descriptor\nby a child\n")


def test_plugin_that_asks_gets_no_answer(that, tmp_path):
    """A plugin that reads standard input fails at once instead of waiting for ever."""
    cell = that("ask")
    _run([cell], tmp_path)
    assert read_manifest(tmp_path / cell.id).reason.startswith("EOFError")


def test_worker_ends_with_its_parent(that, tmp_path):
    """A worker whose standard input closes, as it does when its parent dies, ends in the middle of its cell."""
    note = tmp_path / "pid"
    os.mkfifo(note)
    order = Order(tmp_path / "cell", TrainCell(that("wait", str(note))))
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.DEVNULL}
    with subprocess.Popen([sys.executable, "-m", "harness.experiment.workers.worker"], text=True, **pipes) as worker:
        worker.stdin.write(order.line() + "\n")
        worker.stdin.flush()
        assert int(note.read_text()) == worker.pid
        worker.stdin.close()
        assert worker.wait(30) == 1


def test_worker_dies_with_a_killed_parent(that, tmp_path, toys):
    """SIGKILL of the process that runs the plan ends its workers too."""
    note = tmp_path / "pid"
    os.mkfifo(note)
    cell = that("wait", str(note))
    script = (
        "import json, sys; from pathlib import Path\n"
        "from harness.record.cell import Cell; from harness.executor import Job\n"
        "from harness_plugins.executors.processes import Processes\n"
        "cell = Cell.from_json(json.loads(sys.argv[1]))\n"
        "Processes().run([Job(cell, Path(sys.argv[2]))], 1, lambda event: None)\n"
    )
    parent = subprocess.Popen([sys.executable, "-c", script, json.dumps(cell.to_json()), str(tmp_path / "cell")])
    watch = os.pidfd_open(int(note.read_text()))
    try:
        parent.kill()
        parent.wait()
        ended, _, _ = select.select([watch], [], [], 30.0)
        assert ended == [watch]
    finally:
        os.close(watch)


def _pid_of(folder):
    """Of the process that did a cell, as its log says."""
    return re.search(r"process (\d+)", (folder / LOG).read_text())[1]


def test_a_process_does_several_cells(make_cell, tmp_path):
    """It imports the heavy libraries once."""
    cells = [make_cell(seed=seed) for seed in range(3)]
    _run(cells, tmp_path)
    assert len({_pid_of(tmp_path / cell.id) for cell in cells}) == 1


def test_a_fresh_process_for_every_cell(make_cell, tmp_path):
    """Where the options ask for it."""
    cells = [make_cell(seed=seed) for seed in range(2)]
    _run(cells, tmp_path, options=CellOptions(fresh=True))
    assert len({_pid_of(tmp_path / cell.id) for cell in cells}) == 2


def test_a_process_whose_cell_failed_does_no_other(that, make_cell, tmp_path):
    """What a failure leaves behind in it is not known."""
    cells = [that("raise"), make_cell()]
    _run(cells, tmp_path)
    assert len({_pid_of(tmp_path / cell.id) for cell in cells}) == 2


def test_a_cell_that_hangs_is_ended(that, make_cell, tmp_path):
    """With the reason, and in the log where it stood; the next cell is done."""
    hung, good = that("hang"), make_cell()
    last = _run([hung, good], tmp_path, options=CellOptions(limits=Limits(stall_after=4.0)))
    assert last[hung.id].reason == "no progress for 4 s (--stall-after)"
    log = (partial_folder(tmp_path / hung.id) / LOG).read_text()
    assert "no progress for 4 s (--stall-after): its process is ended, its stack follows" in log
    assert " in _hang" in log
    assert read_manifest(tmp_path / good.id).status == "done"


def test_a_cell_that_takes_too_long_is_ended(that, tmp_path):
    """Whether it gets on or not."""
    cell = that("hang")
    last = _run([cell], tmp_path, options=CellOptions(limits=Limits(cell_time=1.5)))
    assert last[cell.id].reason == "it took longer than the 1.5 s that --cell-time allows"


def test_a_cell_that_hoards_memory_is_ended(that, tmp_path):
    """The machine has other cells to do."""
    cell = that("hoard")
    last = _run([cell], tmp_path, options=CellOptions(limits=Limits(cell_memory=0.5)))
    assert re.fullmatch(r"it used 0\.\d\d GiB of memory, --cell-memory allows 0\.5", last[cell.id].reason)
