"""Evaluation apart from training: fixed starts and targets, the same in every cell."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from harness.arrays import Float32
from harness.conditions import conditions_of
from harness.conditions.varied_robot import Factors, draw_factors
from harness.env.make import World
from harness.experiment.evaluation.work_meter import WorkMeter
from harness.policy import Policy
from harness.record.episode_facts import EpisodeFacts
from harness.record.trace import TraceWriter
from harness.robot import Robot
from harness.task import Task, goal_of

EVALUATION_SEED = 20_211_118
"""Seed of the starts and targets of every evaluation. It is not one of the small numbers that people train with."""

Act = Callable[[Float32], NDArray[Any]]


def evaluate(
    world: World,
    act: Act,
    episodes: int,
    path: Path,
    seed: int = EVALUATION_SEED,
    ik_steps: Sequence[int | None] | None = None,
    on_step: Callable[[], None] = lambda: None,
) -> None:
    """Let `act` do `episodes` episodes, one in each env of a batch, and record them.

    Args:
        world: Where.
        act: Observations (num_envs, observation_size) to actions (num_envs, action_size), or choices (num_envs,).
        episodes: How many.
        path: The trace to write: one episode of each env.
        seed: Of the starts and targets.
        ik_steps: What `harness.experiment.evaluation.ik_steps` says of them, or of more episodes; None where it is not
            asked.
        on_step: Called after every step of the batch.
    """
    env = world.open(episodes, autoreset_mode=AutoresetMode.DISABLED)
    facts = replace(
        facts_of(world.task, world.robot), ik_steps=None if ik_steps is None else tuple(ik_steps[:episodes])
    )
    try:
        sizes, extras = (env.robot.dof, env.episodes.action.shape[1]), env.episodes.extras
        with TraceWriter(path, *sizes, episodes=1, facts=facts, extras=extras) as writer:
            env.recorder = meter = WorkMeter(writer, world)
            observations, _ = env.reset(seed=seed)
            running = np.ones(env.num_envs, bool)
            while running.any():
                observations, _, terminated, truncated, _ = env.step(act(observations))
                running &= ~(terminated | truncated)
                env.rest(~running)
                on_step()
            writer.facts = replace(facts, work=meter.work())
    finally:
        env.close()


def facts_of(task: Task, robot: Robot) -> EpisodeFacts:
    """The facts about a task's episodes that are known before any episode."""
    goal, facts = goal_of(task, robot), EpisodeFacts(task.horizon, task.control_period, arms=_arms(task, robot))
    return facts if goal is None else replace(facts, error=goal.error, unit=goal.unit, target_moves=goal.moves)


def _arms(task: Task, robot: Robot) -> tuple[Factors, ...] | None:
    conditions = conditions_of(task)
    if not conditions.is_varied:
        return None
    return tuple(draw_factors(conditions, robot, number) for number in range(conditions.variants))


def act_of(policy: Policy, deterministic: bool) -> Act:
    """How `policy` acts in an evaluation. What it draws there does not depend on earlier draws."""
    if deterministic:
        return policy.act
    return partial(policy.act, rng=np.random.default_rng([EVALUATION_SEED, 2]))


def random_actions(floor: Policy) -> Act:
    """The random actions of `floor`, a policy that chooses uniformly. They are the same in every evaluation."""
    return partial(floor.act, rng=np.random.default_rng([EVALUATION_SEED, 1]))
