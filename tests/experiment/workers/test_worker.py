"""The process that does cells: orders on standard input, steps on standard output, the rest in the log."""

import os
import shutil
import subprocess
import sys
from contextlib import contextmanager

import pytest

from harness.experiment.run_cell import TrainCell
from harness.experiment.workers.order import Order
from harness.experiment.workers.worker import DONE, STALE
from harness.record import LOG, partial_folder, read_manifest
from harness.registry import Choice

pytestmark = pytest.mark.usefixtures("toys")


@contextmanager
def _worker():
    pipes = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    with subprocess.Popen([sys.executable, "-m", "harness.experiment.workers.worker"], text=True, **pipes) as worker:
        yield worker


def _give(worker, cell, folder):
    """What it answers to an order, until it has done it, or has ended."""
    worker.stdin.write(Order(folder, TrainCell(cell)).line() + "\n")
    worker.stdin.flush()
    answers = []
    for line in worker.stdout:
        answers.append(line.strip())
        if answers[-1] in (DONE, STALE):
            break
    return answers


def _work(cell, folder):
    """The whole life of a worker that does one cell."""
    with _worker() as worker:
        answers = _give(worker, cell, folder)
        worker.stdin.close()
        return subprocess.CompletedProcess(worker.args, worker.wait(30), answers, worker.stderr.read())


def test_worker_tells_nothing_but_steps(make_cell, tmp_path):
    """Standard output has a line per number of steps, what the episodes came to, and an end; the plugin prints."""
    chatting = make_cell(steps=3, algorithm=Choice("wander", (("then", "chat"),), "wander:then=chat"))
    ended = _work(chatting, tmp_path / "cell")
    *counts, learned, last = ended.stdout
    assert (ended.returncode, counts, last, ended.stderr) == (0, ["0", "1", "2", "3"], DONE, "")
    assert learned.startswith('3 {"Training/')
    assert "by print" in (tmp_path / "cell" / LOG).read_text()


def test_manifest_records_what_the_user_typed(make_cell, tmp_path, monkeypatch):
    """The command of the process that gave the order, not the worker's own."""
    monkeypatch.setattr("sys.argv", ["/usr/bin/harness", "run", "--sim", "ideal"])
    _work(make_cell(), tmp_path / "cell")
    assert read_manifest(tmp_path / "cell").environment["command"] == "harness run --sim ideal"


def test_failed_cell_is_no_failed_worker(make_cell, tmp_path):
    """It left a manifest with the reason, and the traceback in the log; it does no other cell after that."""
    raising = make_cell(algorithm=Choice("wander", (("then", "raise"),), "wander:then=raise"))
    with _worker() as worker:
        assert DONE not in _give(worker, raising, tmp_path / "cell")
        assert worker.wait(30) == 0
    assert read_manifest(tmp_path / "cell").reason == "RuntimeError: the arm fell off"
    assert "Traceback" in (tmp_path / "cell" / LOG).read_text()


def test_a_worker_does_one_cell_after_the_other(make_cell, tmp_path):
    """Each into its own folder, with what its plugins print in its own log."""
    chatting = Choice("wander", (("then", "chat"),), "wander:then=chat")
    with _worker() as worker:
        for seed in range(2):
            assert _give(worker, make_cell(seed=seed, algorithm=chatting), tmp_path / str(seed))[-1] == DONE
        worker.stdin.close()
        assert worker.wait(30) == 0
    for seed in range(2):
        assert read_manifest(tmp_path / str(seed)).cell.seed == seed
        assert (tmp_path / str(seed) / LOG).read_text().count("by print") == 1


def test_sources_that_changed_are_not_mixed(make_cell, tmp_path, toy_folder, monkeypatch):
    """The manifest would name what is on the disk, and what had been loaded would run: a fresh process has to do it."""
    folder = shutil.copytree(toy_folder, tmp_path / "installed")
    monkeypatch.setenv("PYTHONPATH", f"{folder}{os.pathsep}{os.environ['PYTHONPATH']}")
    with _worker() as worker:
        assert _give(worker, make_cell(), tmp_path / "first")[-1] == DONE
        (folder / "toy_arm.py").touch()
        assert _give(worker, make_cell(seed=1), tmp_path / "second") == [STALE]
        assert worker.wait(30) == 0
    assert not (tmp_path / "second").exists()


def test_a_crash_leaves_its_stack_in_the_log(make_cell, tmp_path):
    """A fault in a library's machine code would else end the process without a word."""
    with _worker() as worker:
        _give(worker, make_cell(algorithm=Choice("wander", (("then", "crash"),), "crash")), tmp_path / "cell")
        assert worker.wait(30) < 0
    assert "Fatal Python error: Segmentation fault" in (partial_folder(tmp_path / "cell") / LOG).read_text()


def test_a_log_is_not_written_into_a_file_of_somebody_else(make_cell, tmp_path):
    """A log that was left as a second name of a file is replaced before the worker prints into it."""
    elsewhere, partial = tmp_path / "diary.txt", partial_folder(tmp_path / "cell")
    elsewhere.write_text("mine")
    partial.mkdir()
    os.link(elsewhere, partial / "log.txt")
    _work(make_cell(), tmp_path / "cell")
    assert elsewhere.read_text() == "mine"


def test_no_character_that_is_printed_ends_a_training(tmp_path):
    """One that the log's encoding has not is written out in the log."""
    code = "import pathlib, sys; from harness.experiment.workers.worker import print_into as p; p(pathlib.Path('log'))"
    command = [sys.executable, "-c", f"{code}; print('caf\u00e9')"]
    environment = {**os.environ, "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "1"}
    assert subprocess.run(command, cwd=tmp_path, env=environment, check=False).returncode == 0
    assert (tmp_path / "log").read_bytes().strip() == b"caf\\xe9"
