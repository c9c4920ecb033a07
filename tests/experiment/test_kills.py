"""Runs that are killed at any moment and started again end as if they had not been."""

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from harness.experiment.verify import verify
from harness.record import Store
from tests.left import left_by_cells

# A shell that starts this in the background has INT ignored, which children inherit. Before `main` is there, Python
# alone decides what INT does: here it ends the process, so that any traceback is ours.
PROGRAM = (
    "import signal; signal.signal(signal.SIGINT, signal.SIG_DFL); from harness.cli import main;"
    "signal.signal(signal.SIGINT, signal.default_int_handler); main()"
)
RUN = [sys.executable, "-c", PROGRAM, "run"]
MATRIX = ["--seeds", "1", "--evaluation-episodes", "2", "--jobs", "2"]
ARM = ["--sim", "kinematic", "--task", "fd100-reach:horizon=50"]
LINE = ["--plugin", str(Path(__file__).parent / "environments" / "toy.py"), "--task", "toy", "--baseline", "near"]
CASES = {
    "random,spg": (ARM, 2000, 500, 160),
    "sac-fast,sb3-sac,ppo": (ARM, 600, 150, 40),
    "random,sac-fast": (LINE, 1600, 200, 40),
}
"""Algorithms; where, steps, steps from one checkpoint to the next, and how many kills."""
TO_ALL = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)


def _start(algorithms, folder, err):
    """A run in a session of its own: what is killed here is what we choose."""
    where, steps, every, _ = CASES[algorithms]
    with err.open("ab") as file:
        command = [*RUN, *MATRIX, *where, "--algo", algorithms, "--steps", str(steps), "--checkpoint-every", str(every)]
        command += ["--out", str(folder)]
        return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=file, start_new_session=True)


def _workers(parent):
    told = subprocess.run(["pgrep", "-P", str(parent)], capture_output=True, text=True, check=False)
    return [int(line) for line in told.stdout.split()]


def _disturb(process, rng):
    """Kill the run, or one of its workers alone, in one of the ways in which that happens."""
    how = rng.choice([*TO_ALL, None])
    if how is not None:
        process.send_signal(how)
    elif workers := _workers(process.pid):
        os.kill(rng.choice(workers), signal.SIGKILL)


@pytest.mark.skipif(shutil.which("pgrep") is None, reason="there is no pgrep")
@pytest.mark.slow
@pytest.mark.parametrize("algorithms", CASES)
def test_killed_runs_lose_nothing(tmp_path, algorithms):
    """KILL, TERM, INT, or a worker alone: afterwards every byte is that of an undisturbed run, and no traceback."""
    whole, err, rng = tmp_path / "whole", tmp_path / "err", random.Random(7)
    began = time.monotonic()
    assert _start(algorithms, whole, err).wait() == 0
    seconds, expected = time.monotonic() - began, left_by_cells(whole)
    assert len(Store(whole).manifests()) == len(Store(whole).read_plan().cells)
    done, kills = 0, CASES[algorithms][-1]
    while done < kills:
        folder = tmp_path / f"killed-{done}"
        finished = False
        while not finished:
            before = {manifest.cell.id for manifest in Store(folder).manifests() if manifest.status == "done"}
            process = _start(algorithms, folder, err)
            if done < kills:
                time.sleep(rng.uniform(0.0, seconds))
                _disturb(process, rng)
                done += process.poll() is None
            finished = process.wait() == 0
            assert before <= {manifest.cell.id for manifest in Store(folder).manifests() if manifest.status == "done"}
        assert left_by_cells(folder) == expected
        assert verify(folder) == []
        shutil.rmtree(folder)
    assert b"Traceback" not in err.read_bytes()
