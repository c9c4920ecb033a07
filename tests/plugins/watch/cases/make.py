"""Trains every case with three seeds, and keeps each episode: ``python -m tests.plugins.watch.cases.make FOLDER``.

What FOLDER has already is not trained again. ``episodes.parquet`` has a row for each episode: case, seed, steps of the
training when it ended, pay, behaviour.
"""

import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from harness import RecordRewards
from harness.record import read_recording
from harness.record.recording.recorded_training import is_recording
from tests.plugins.watch.cases.plain import LEARNERS
from tests.plugins.watch.cases.table import CASES, WORLDS

HERE = Path(__file__).parent
KEPT = HERE / "episodes.parquet"
SEEDS = (0, 1, 2)


def train(case, folder):
    """Train a case with the seeds that are not there."""
    make, measure, behaviour = WORLDS[case.world]
    for seed in [it for it in SEEDS if not _is_closed(folder / str(it))]:
        with RecordRewards(
            make(), folder / str(seed), trained_with=case.reward, rewards={case.reward: case.given}, pay=True,
            behaviour={measure: behaviour}, **{f"{case.better}_is_better": [measure]},
        ) as env:  # fmt: skip
            LEARNERS[case.learner](env, case.steps, seed)


def _is_closed(folder):
    return is_recording(folder) and read_recording(folder).facts.closed


def episodes(path, case):
    """Of a training: steps when each ended, pay, behaviour."""
    names = f"reward/{case.reward}", f"behaviour/{case.measure}"
    rows = read_recording(path).rows(("terminated", "truncated", *names))
    pay, behaviour = (rows[it] for it in names)
    ends = np.flatnonzero(rows["terminated"] | rows["truncated"])
    return ends + 1, np.diff(np.cumsum(pay)[ends], prepend=0.0), behaviour[ends].astype(float)


def main(folder):
    """Train what is not there, and write the table."""
    tables = []
    for case in CASES:
        of_case = folder / case.name.replace(" ", "-").replace(":", "-")
        train(case, of_case)
        for seed in SEEDS:
            steps, pay, behaviour = episodes(of_case / str(seed), case)
            columns = {"case": [case.name] * len(steps), "seed": [seed] * len(steps), "steps": steps}
            tables.append(pa.table({**columns, "pay": pay.astype("f4"), "behaviour": behaviour.astype("f4")}))
        sys.stdout.write(f"{case.name}\n")
        sys.stdout.flush()
        pq.write_table(pa.concat_tables(tables), KEPT, compression="zstd")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
