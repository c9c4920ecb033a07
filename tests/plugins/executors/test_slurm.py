"""Cells as jobs of a Slurm cluster, and of submitit's own stand-in for one."""

import os
import re
import subprocess
import threading
import time

import psutil
import pytest

from harness.executor import CellOptions, Event, Job
from harness.record import LOG, Store, partial_folder
from harness_plugins.executors.slurm import Slurm
from tests.refusals import refused

pytestmark = [
    pytest.mark.slow,
    pytest.mark.usefixtures("toys"),
    # submitit does not wait for the processes that it starts in Slurm's place.
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
]


@pytest.fixture(autouse=True)
def submitit():
    """Is an extra."""
    pytest.importorskip("submitit")


def test_jobs_are_not_read_from_the_experiments_folder(that, tmp_path, state):
    """While a cell runs, its pickle lies in the user's own folder, and the experiment's has none."""
    pickles = []
    cell = that("last", tmp_path / "note")
    job = Job(cell, tmp_path / "cells" / cell.id)
    Slurm(cluster="local").run([job], 1, lambda event: pickles.extend(tmp_path.rglob("*.pkl")))
    assert pickles
    assert [path for path in pickles if not path.is_relative_to(state)] == []


def test_a_cluster_that_takes_no_jobs_is_told(that, tmp_path, monkeypatch):
    """As where Slurm is installed and not configured: what sbatch said last, and what to do."""
    complaint = "echo 'sbatch: error: no host' >&2; echo 'sbatch: fatal: no source' >&2; exit 1"
    for name in ("sbatch", "srun"):
        (tmp_path / name).write_text(f"#!/bin/sh\n{complaint}\n")
        (tmp_path / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    cell = that("last", tmp_path / "note")
    with refused(r"^Slurm takes no jobs: sbatch: fatal: no source\. Run harness where sbatch"):
        Slurm().run([Job(cell, tmp_path / "cells" / cell.id)], 1, lambda event: None)


def test_a_job_that_can_tell_nothing_more_is_told(slurm, that, tmp_path, state):
    """The cell has failed, with what the cluster says; its log is kept, and the jobs' folder is removed."""
    note, told = tmp_path / "note", list[Event]()
    cell = that("wait", note)

    def kill():
        while not note.exists():
            time.sleep(0.1)
        for process in psutil.process_iter(["cmdline"]):
            if str(tmp_path) in " ".join(process.info["cmdline"] or ()):
                process.kill()

    thread = threading.Thread(target=kill)
    thread.start()
    Slurm(memory=0.5).run([Job(cell, tmp_path / "cells" / cell.id)], 1, told.append)
    thread.join()
    assert [event.kind for event in told if event.kind != "progress"] == ["started", "ended"]
    assert re.fullmatch("its job [0-9]+(_0)? is FAILED", told[-1].reason)
    assert " is FAILED" in (partial_folder(tmp_path / "cells" / cell.id) / LOG).read_text()
    assert list(state.iterdir()) == []


def test_a_job_that_has_to_make_room_goes_on(slurm, that, tmp_path):
    """The cluster queues it again, and the cell is told to have begun once."""
    note, told = tmp_path / "note", list[Event]()
    cell = that("last", note)

    def make_room():
        while not note.exists():
            time.sleep(0.02)
        subprocess.run(["scancel", "--signal=USR2", "--name=harness"], check=True)

    thread = threading.Thread(target=make_room)
    thread.start()
    job = Job(cell, tmp_path / "cells" / cell.id, CellOptions(checkpoint_every=1))
    Slurm(memory=0.5).run([job], 1, told.append)
    thread.join()
    assert [event.kind for event in told if event.kind != "progress"] == ["started", "ended"]
    assert Store(tmp_path).examine(cell).status == "done"


def test_without_a_cluster_it_says_what_there_is(make_cell, tmp_path, state, monkeypatch):
    """Nothing is left in the folder of the jobs."""
    monkeypatch.setenv("PATH", "/nowhere")
    with refused(r"No Slurm cluster: .* Run harness where sbatch works"):
        Slurm().run([Job(make_cell(), tmp_path / "cells" / "one")], 1, lambda event: None)
    assert list(state.iterdir()) == []
