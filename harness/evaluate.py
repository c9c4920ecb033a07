"""Evaluation apart from training: fixed starts and targets, the same in every cell."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.cell import Cell
from harness.make import build_env
from harness.plugins import Registry
from harness.trace import TraceWriter

EVALUATION_SEED = 20_211_118
"""Of the starts and targets of every evaluation; not among the small numbers that people seed training with."""

Act = Callable[[NDArray[np.float32]], NDArray[np.float32]]


def evaluate(cell: Cell, registry: Registry, act: Act, path: Path) -> None:
    """Let `act` do the cell's evaluation episodes, one in each env of a batch, and record them.

    Args:
        cell: Whose simulator, robot, task and reward.
        registry: The plugins.
        act: Observations (num_envs, observation_size) to actions (num_envs, action_size).
        path: The trace to write: one episode of each env.
    """
    env = build_env(
        registry, cell.simulator, cell.task, cell.reward, robot=cell.robot, num_envs=cell.evaluation_episodes
    )
    sizes: dict[str, Any] = {"dof": env.robot.dof, "action_size": env.robot.dof}
    try:
        with TraceWriter(path, **sizes, episodes=1) as recorder:
            env.recorder = recorder
            observations, _ = env.reset(seed=EVALUATION_SEED)
            running = np.ones(env.num_envs, bool)
            while running.any():
                observations, _, terminated, truncated, _ = env.step(act(observations))
                running &= ~(terminated | truncated)
    finally:
        env.close()


def random_actions(action_size: int) -> Act:
    """The floor: actions drawn uniformly, whatever is observed."""
    rng = np.random.default_rng([EVALUATION_SEED, 1])

    def act(observations: NDArray[np.float32]) -> NDArray[np.float32]:
        return rng.uniform(-1.0, 1.0, (len(observations), action_size)).astype(np.float32)

    return act
