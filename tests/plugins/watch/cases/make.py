"""Trains every case with three seeds, and keeps each episode: ``python -m tests.plugins.watch.cases.make FOLDER``.

What FOLDER has already is not trained again. ``episodes.parquet`` has a row for each episode: case, seed, steps of the
training when it ended, pay, behaviour.
"""

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from harness import RecordRewards
from harness.record.recording.recorded_training import is_recording, read_recording
from harness.record.trace import read_trace
from tests.plugins.watch.cases.plain import LEARNERS
from tests.plugins.watch.cases.table import CASES, WORLDS, Case

HERE = Path(__file__).parent
AUDIT = HERE.parents[1] / "audit" / "cases"
KEPT = HERE / "episodes.parquet"
SEEDS = (0, 1, 2)
PAID = ("reward", "reward_ground", "reward_target", "reward_step")
"""What a step of an arm pays together."""


def train(case: Case, folder: Path) -> None:
    """Train a case with the seeds that are not there."""
    if case.learner not in LEARNERS:
        kind = "cartpole" if case.world == "cartpole" else "arm"
        where = (
            ["--task", "gymnasium:id=CartPole-v1"]
            if kind == "cartpole"
            else ["--task", case.world, "--sim", "kinematic"]
        )
        files = [AUDIT / kind / "rewards.py", *([HERE / kind / "behaviour.py"] if kind == "cartpole" else [])]
        call = [
            sys.executable, "-m", "harness", "run", *where, "--algo", case.learner, "--reward", case.reward,
            "--baseline", "none", *(it for file in files for it in ("--plugin", str(file))), "--steps", str(case.steps),
            "--seeds", str(len(SEEDS)), "--jobs", "1", "--evaluation-episodes", "2", "--out", str(folder),
        ]  # fmt: skip
        subprocess.run(call, check=True, stdout=subprocess.DEVNULL)  # goes on where it stopped
        return
    make, measure, behaviour = WORLDS[case.world]
    for seed in [it for it in SEEDS if not _is_closed(folder / str(it))]:
        with RecordRewards(
            make(), folder / str(seed), trained_with=case.reward, rewards={case.reward: case.given}, pay=True,
            behaviour={measure: behaviour},
        ) as env:  # fmt: skip
            LEARNERS[case.learner](env, case.steps, seed)


def _is_closed(folder: Path) -> bool:
    return is_recording(folder) and read_recording(folder).facts.closed


def episodes(path: Path, case: Case) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of a training: steps when each ended, pay, behaviour."""
    if path.suffix == ".parquet":
        rows = read_trace(path).without_starts().rows(("terminated", "truncated", "reached", *PAID))
        pay, behaviour = sum(rows[it] for it in PAID), rows["reached"]
    else:
        names = f"reward/{case.reward}", f"behaviour/{case.measure}"
        rows = read_recording(path).rows(("terminated", "truncated", *names))
        pay, behaviour = (rows[it] for it in names)
    ends = np.flatnonzero(rows["terminated"] | rows["truncated"])
    return ends + 1, np.diff(np.cumsum(pay)[ends], prepend=0.0), behaviour[ends].astype(float)


def trainings(case: Case, folder: Path) -> Iterator[tuple[int, Path]]:
    """The seeds of a case, each with what was recorded."""
    if case.learner in LEARNERS:
        yield from ((seed, folder / str(seed)) for seed in SEEDS)
    else:
        for cell in folder.glob("cells/[!.]*"):
            trace = cell / "trace.parquet"
            seed = json.loads((cell / "manifest.json").read_text())["cell"]["seed"]
            yield seed, trace if trace.exists() else cell / "training"


def main(folder: Path) -> None:
    """Train what is not there, and write the table."""
    tables = []
    for case in sorted(CASES, key=lambda it: it.learner not in LEARNERS):
        of_case = folder / case.name.replace(" ", "-").replace(":", "-")
        train(case, of_case)
        for seed, path in sorted(trainings(case, of_case)):
            steps, pay, behaviour = episodes(path, case)
            columns = {"case": [case.name] * len(steps), "seed": [seed] * len(steps), "steps": steps}
            tables.append(pa.table({**columns, "pay": pay.astype("f4"), "behaviour": behaviour.astype("f4")}))
        sys.stdout.write(f"{case.name}\n")
        sys.stdout.flush()
        pq.write_table(pa.concat_tables(tables), KEPT, compression="zstd")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
