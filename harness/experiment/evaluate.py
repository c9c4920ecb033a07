"""Evaluation apart from training: fixed starts and targets, the same in every cell."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float32
from harness.env.make import build_env
from harness.policy import Policy
from harness.record.cell import Cell
from harness.record.trace import TraceWriter
from harness.registry.registry import Registry

EVALUATION_SEED = 20_211_118
"""Of the starts and targets of every evaluation; not among the small numbers that people seed training with."""

Act = Callable[[Float32], NDArray[Any]]


def evaluate(cell: Cell, registry: Registry, act: Act, path: Path, seed: int = EVALUATION_SEED) -> None:
    """Let `act` do the cell's evaluation episodes, one in each env of a batch, and record them.

    Args:
        cell: Whose simulator, robot, task and reward.
        registry: The plugins.
        act: Observations (num_envs, observation_size) to actions (num_envs, action_size), or choices (num_envs,).
        path: The trace to write: one episode of each env.
        seed: Of the starts and targets.
    """
    env = build_env(
        registry, cell.simulator, cell.task, cell.reward, robot=cell.robot, num_envs=cell.evaluation_episodes
    )
    try:
        with TraceWriter(path, env.robot.dof, env.episodes.action.shape[1], episodes=1) as recorder:
            env.recorder = recorder
            observations, _ = env.reset(seed=seed)
            running = np.ones(env.num_envs, bool)
            while running.any():
                observations, _, terminated, truncated, _ = env.step(act(observations))
                running &= ~(terminated | truncated)
    finally:
        env.close()


def act_of(policy: Policy, cell: Cell) -> Act:
    """How `policy` acts in an evaluation of the cell; what it draws there depends on nothing that was drawn before."""
    if cell.deterministic:
        return policy.act
    return partial(policy.act, rng=np.random.default_rng([EVALUATION_SEED, 2]))


def random_actions(floor: Policy) -> Act:
    """What `floor`, a policy that chooses uniformly, draws; the same in every evaluation."""
    return partial(floor.act, rng=np.random.default_rng([EVALUATION_SEED, 1]))
