"""A script that records, is killed at any moment and started again, leaves what it would have left."""

import random
import subprocess
import sys
import time

import numpy as np
import pytest

from harness.record import read_recording
from harness.record.recording import recorded_training
from tests.left import files_of

PART, EPISODES, STEPS = 512, 100, 100
LATE = 256
"""So many steps later a part is on the disk: rows are made together."""
SCRIPT = f"""
import sys, gymnasium, harness, numpy as np
from pathlib import Path
from harness.record import read_recording
from harness.record import parts
from harness.record.recording import recorded_training

recorded_training.PART_ROWS = parts.PART_ROWS = {PART}
parts.WRITE_EVERY = parts.SOONEST = 0.02
folder = Path(sys.argv[1])
there = read_recording(folder)["episode"] if recorded_training.is_recording(folder) else np.empty(0, int)
rewards = {{"turn": lambda step: float(step.observation[0]), "speed": lambda step: abs(float(step.observation[2]))}}
env = gymnasium.make("Pendulum-v1", max_episode_steps={STEPS})
env = harness.RecordRewards(env, folder, trained_with="own", rewards=rewards, seed=0, resume=True)
steps = len(there)
print("begun", flush=True)
for episode in range(there.max(initial=-1) + 1, {EPISODES}):
    env.reset(seed=episode)
    for action in np.random.default_rng(episode).uniform(-2.0, 2.0, ({STEPS}, 1)):
        env.step(action)
        steps += 1
        if steps % {PART} == {LATE}:
            print(steps - {LATE}, flush=True)
env.close()
"""


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Starts the script, and kills it so many seconds after it has begun, if it still runs; returns what it told."""
    monkeypatch.setattr(recorded_training, "PART_ROWS", PART)
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)

    def start(folder, until=None):
        with subprocess.Popen([sys.executable, script, folder], stdout=subprocess.PIPE) as process:
            assert process.stdout is not None
            assert process.stdout.readline() == b"begun\n"
            if until is not None:
                time.sleep(until)
                process.kill()
            told = [int(line) for line in process.stdout]
        return process.returncode, told

    return start


def _whole_parts(folder):
    """Of the files of steps all but the last, and what is in each."""
    files = {path.name: content for path, content in files_of(folder).items() if path.suffix == ".parquet"}
    return {name: files[name] for name in sorted(files)[:-1]}


@pytest.mark.parametrize("kills", [2, pytest.param(40, marks=pytest.mark.slow)])
def test_a_killed_recorder_loses_no_part(run, tmp_path, kills):
    """No byte of a part changes. Each row is that of an undisturbed script, and at its end no episode is missing."""
    rng, began = random.Random(7), time.monotonic()
    assert run(tmp_path / "whole")[0] == 0
    seconds, whole = time.monotonic() - began, read_recording(tmp_path / "whole")
    expected = whole.rows().columns
    names = whole.names[2:]  # behind the two counts of rows, which an episode that was cut short moves on
    done = 0
    while done < kills:
        folder, status, parts = tmp_path / f"killed-{done}", -9, {}
        while status:
            status, told = run(folder, rng.uniform(0.0, seconds / 4) if done < kills else None)
            assert status in (0, -9)
            done += status != 0
            left, found = _whole_parts(folder), read_recording(folder)
            assert parts.items() <= left.items()
            assert len(found) >= max(told, default=0)
            parts, rows = left, found.rows().columns
            at = (rows["episode"] * STEPS + rows["step"]).astype(int)  # of no row a float
            for name in names:
                assert rows[name].tobytes() == expected[name][at].tobytes()
        assert set(np.unique(rows["episode"])) == set(range(EPISODES))
