"""What tests of scores write: files of an arm's steps, and a trace of one joint with its manifest."""

import random

import numpy as np
import pytest

from harness.record import COLUMN, SCALARS, Manifest, TraceWriter

HEADER = "t,beginDistance,prevBest,distance,delta_distance,reward"


def arp(k2, k1=1.0):
    """What ARP pays for beginDistance, best distance before the step, and distance; the baseline where both are 1."""
    return lambda begin, before, distance: -k1 * (distance - before) if distance > before else k2 * (begin - distance)


def write_run(path, pay, seed, rows, program="K2", pace=0.2):
    """Episodes of an arm that learns to come closer, in the words of either program, 7 digits a number."""
    rng, lines, step = random.Random(seed), [HEADER], 0
    begin = before = distance = 1.0
    for number in range(rows):
        if step == 0:
            begin = before = distance = 1.0 + 0.5 * rng.random()
            reward = 0.0
        else:
            distance = abs(distance + (rng.random() - 0.3 - number / rows) * pace)
            reward = pay(begin, before, distance)
        after, best = min(before, distance), before
        numbers = (begin, after, distance, distance - best, reward)
        if program == "base line":
            numbers = (begin, best, distance, None if step else 0.0, reward)
        texts = ["" if number is None else f"{number:.7g}".upper() for number in numbers]
        lines.append(",".join([str(step) if program == "K2" else "", *texts]))
        before, step = after, 0 if rng.random() < 0.1 else step + 1
    path.parent.mkdir(exist_ok=True)
    path.write_text("\n".join(lines) + "\n")


def _write_trace(folder, cell, columns):
    rows = np.zeros((len(columns["step"]), len(SCALARS) + 2))
    for name, values in columns.items():
        rows[:, COLUMN[name]] = values
    path = folder / "trace.parquet"
    with TraceWriter(path, 1, 1) as writer:
        writer.append(rows)
    Manifest(cell, status="done").write(folder)
    return path


@pytest.fixture
def write_trace(make_cell):
    """A trace with these columns, in a folder, of a cell that differs so from the usual one."""
    return lambda folder, columns, **cell: _write_trace(folder, make_cell(**cell), columns)
