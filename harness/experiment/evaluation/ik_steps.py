"""How many steps inverse kinematics take to the target. The steps of an evaluation are compared with them."""

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from harness.env.known_arm import kinematics_policy, why_not_kinematics
from harness.env.make import World
from harness.errors import SimulationDiverged
from harness.record.trace import COLUMN, Rows
from harness.registry.sources import description
from harness.task import varies


def ik_steps(world: World, episodes: int, seed: int) -> tuple[int | None, ...] | None:
    """The environment steps to the first target, by env; None of an env where it is not reached.

    `harness.policy.InverseKinematics` acts, in the same world and from the same starts. It does not look out for the
    ground: an episode that ends there has not reached its target.

    Args:
        world: Where.
        episodes: How many, one in each env of a batch.
        seed: Of the starts and targets.

    Returns:
        None where the kinematics cannot act, or the simulation diverges under them: that costs no cell.
    """
    if why_not_kinematics(world.task, world.robot):
        return None
    parts = (description(world.simulator), description(world.task), world.robot.driven_digest)
    return _answer(_Question(parts, episodes, seed, world))


@dataclass(frozen=True)
class _Question:
    """Everything that the answer depends on, and the world in which it is found, which adds nothing to that."""

    parts: tuple[str, ...]
    episodes: int
    seed: int
    world: World = field(compare=False)


@lru_cache(maxsize=16)
def _answer(question: _Question) -> tuple[int | None, ...] | None:
    """The answer. A process that does several cells computes it once."""
    world, episodes, seed = question.world, question.episodes, question.seed
    try:
        if varies(world.task):
            return _play(world, episodes, seed)
        return _play(world, 1, seed) * episodes
    except SimulationDiverged:
        return None


def _play(world: World, episodes: int, seed: int) -> tuple[int | None, ...]:
    policy, first = kinematics_policy(world.task, world.robot), _FirstReach(episodes)
    env = world.open(episodes, recorder=first, autoreset_mode=AutoresetMode.DISABLED)
    try:
        seen, _ = env.reset(seed=seed)
        running = np.ones(episodes, bool)
        while running.any():
            seen, _, terminated, truncated, infos = env.step(policy.act(seen))
            running &= ~(terminated | truncated | infos["is_success"])
            env.rest(~running)
    finally:
        env.close()
    return tuple(int(step) if step else None for step in first.steps)


class _FirstReach:
    """A `Recorder` that keeps the step in which the target is reached first in each env's first episode; else 0."""

    def __init__(self, num_envs: int) -> None:
        self.steps: NDArray[np.int64] = np.zeros(num_envs, np.int64)

    def append(self, rows: Rows) -> None:
        """See `harness.record.trace.Recorder`."""
        env, step = rows[:, COLUMN["env"]].astype(int), rows[:, COLUMN["step"]].astype(int)
        is_first = (rows[:, COLUMN["reached"]] > 0.0) & (rows[:, COLUMN["episode"]] == 0.0) & (self.steps[env] == 0)
        self.steps[env[is_first]] = step[is_first]
