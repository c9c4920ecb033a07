"""The way of each episode to its first target, in steps and in metres. Several metrics use it."""

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.errors import Unmeasured
from harness.log import Log
from harness.record.trace import episode_facts


def steps_to_target(trace: Log) -> NDArray[np.int64]:
    """How many environment steps each finished episode takes to its first target, (episodes,).

    The number is 0 if the episode reaches no target. The order is that of `Log.episodes`.
    """
    reached = trace["reached"]
    first = np.array([rows[reached[rows].argmax()] for rows in trace.episodes], np.int64)
    steps: NDArray[np.int64] = np.where(reached[first], trace["step"][first], 0)
    return steps


def paths_to_target(trace: Log) -> Float:
    """Lengths of the end effector's path to the first target and of the straight line, for each finished episode.

    The line leads from the end effector's place at the start to its place when it reaches the target.

    Returns:
        Path and line, [m], shape (episodes, 2), in the order of `Log.episodes`; NaN if the episode reaches no target.

    Raises:
        Unmeasured: The target moves. Where the line should end is not known before the target is reached.
    """
    if episode_facts(trace).target_moves:
        raise Unmeasured("the target moves: no straight line is the shortest way to it")
    position = np.stack([trace[f"end_effector_{axis}"] for axis in "xyz"], axis=1)
    lengths = np.full((len(trace.episodes), 2), np.nan)
    for episode, rows in enumerate(trace.episodes):
        reached = trace["reached"][rows]
        if reached.any():
            path = position[rows[: reached.argmax() + 1]]
            lengths[episode, 0] = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
            lengths[episode, 1] = np.linalg.norm(path[-1] - path[0])
    return lengths
