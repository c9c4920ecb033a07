"""The process of one cell: an order on standard input, steps on standard output, the rest in the log."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from harness.experiment.order import Order
from harness.experiment.run_cell import TrainCell
from harness.record.cell import Cell
from harness.record.folder import LOG
from harness.record.manifest import read_manifest
from harness.registry.choice import Choice

pytestmark = pytest.mark.usefixtures("toys")


def _work(cell: Cell, folder: Path) -> "subprocess.CompletedProcess[str]":
    """A worker's whole life; its standard input stays open until it has ended."""
    pipes = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    with subprocess.Popen([sys.executable, "-m", "harness.experiment.worker"], text=True, **pipes) as worker:
        worker.stdin.write(Order(folder, TrainCell(cell)).line() + "\n")
        worker.stdin.flush()
        out, err = worker.stdout.read(), worker.stderr.read()
        return subprocess.CompletedProcess(worker.args, worker.wait(), out, err)


def test_worker_tells_nothing_but_steps(make_cell: Callable[..., Cell], tmp_path: Path):
    """One line per number of steps on standard output, though the plugin prints; nothing on standard error."""
    chatting = make_cell(steps=3, algorithm=Choice("wander", (("then", "chat"),), "wander:then=chat"))
    ended = _work(chatting, tmp_path / "cell")
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "1\n2\n3\n", "")
    assert "by print" in (tmp_path / "cell" / LOG).read_text()


def test_manifest_records_what_the_user_typed(
    make_cell: Callable[..., Cell], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """The command of the process that gave the order, not the worker's own."""
    monkeypatch.setattr("sys.argv", ["/usr/bin/harness", "run", "--sim", "ideal"])
    _work(make_cell(), tmp_path / "cell")
    assert read_manifest(tmp_path / "cell").environment["command"] == "harness run --sim ideal"


def test_failed_cell_is_no_failed_worker(make_cell: Callable[..., Cell], tmp_path: Path):
    """The worker did what it had to: it left a manifest with the reason, and the traceback in the log."""
    raising = make_cell(algorithm=Choice("wander", (("then", "raise"),), "wander:then=raise"))
    assert _work(raising, tmp_path / "cell").returncode == 0
    assert read_manifest(tmp_path / "cell").reason == "RuntimeError: the arm fell off"
    assert "Traceback" in (tmp_path / "cell" / LOG).read_text()
