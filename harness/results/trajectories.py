"""Where the end effector went in the evaluation episodes of a comparison. Reads results only."""

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from harness.arrays import Float
from harness.record.folder import EVALUATION
from harness.record.trace import read_trace
from harness.results.comparison import Comparison
from harness.results.pairs import cells_by_seed
from harness.results.results import Results

EPISODES = 30
"""The most episodes that are read of an evaluation. More paths could not be told apart."""
POINTS, AXES = ("end_effector", "target"), "xyz"


class Trajectory(NamedTuple):
    """One episode, from its start to the first time that the target is reached, or else to its end."""

    points: Float
    """Places of the end effector at the start and after each step, (steps + 1, 3), world frame, [m]."""
    target: Float
    """The target, (3,), world frame, [m]."""
    reached: bool


@dataclass(frozen=True)
class Trajectories:
    """The first episodes of two evaluations, which began in the same poses with the same targets.

    Attributes:
        seed: The seed of both trainings.
        baseline: The paths under the baseline reward.
        proposed: The paths under the proposed reward.
    """

    seed: int
    baseline: tuple[Trajectory, ...]
    proposed: tuple[Trajectory, ...]


def trajectories_of(results: Results, comparison: Comparison) -> Trajectories | None:
    """The end effector's paths under both rewards, for the first seed that both have.

    None if there is no such seed, or for the null control, which has only one reward.

    Raises:
        SchemaError: A file is damaged or written by a newer version.
    """
    if not comparison.seeds or comparison.is_control:
        return None
    files = [results.store.cell_folder(cells[0]) / EVALUATION for cells in cells_by_seed(results, comparison) if cells]
    if not files or not all(map(Path.is_file, files)):  # recordings of no arm
        return None
    baseline, proposed = map(_read, files)
    return Trajectories(comparison.seeds[0], baseline, proposed)


def _read(path: Path) -> tuple[Trajectory, ...]:
    trace = read_trace(path)
    found = []
    for rows in trace.episodes[:EPISODES]:
        reached = trace["reached"][rows]
        way = rows[: reached.argmax() + 1] if reached.any() else rows
        points, targets = (np.stack([trace[f"{it}_{axis}"][way] for axis in AXES], axis=1) for it in POINTS)
        found.append(Trajectory(points, targets[0], bool(reached.any())))
    return tuple(found)
