"""Recorded rollouts of the scripted policies: the same starts and targets for all."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from harness.arrays import Float, Mask
from harness.env import ReachVectorEnv
from harness.errors import UsageError
from harness.experiment.evaluation.evaluate import EVALUATION_SEED
from harness.payoff.scripted import SCRIPTS, plan_actions
from harness.reward import Array, Carry, Steps
from harness.reward.steps import ARM_BEFORE
from harness.robot import Robot
from harness.simulator import Simulator
from harness.task import Task, goal_of

States: TypeAlias = Mapping[str, NDArray[Any]]
"""What n arms were like before the first step and after each one, by the names of `harness.reward.steps.ARM`, (steps +
1, n, ...); ``distance`` is always there."""


@dataclass(frozen=True)
class Unpaid:
    """The reward that pays nothing: what its env pays are the event terms alone."""

    def initial_carry(self, begin_distance: Array) -> Carry:
        """Remembers nothing."""
        return ()

    def __call__(self, carry: Carry, steps: Steps) -> tuple[Carry, Array]:
        """Zeros, (num_envs,)."""
        return carry, 0.0 * steps.distance


@dataclass(frozen=True, eq=False)
class Rollout:
    """What one script did in n episodes; no reward enters.

    Attributes:
        script: Its name.
        states: What the arms were like, row 0 at the start; the action is that of the step before. An arm whose
            episode has ended goes on until the last one's has.
        events: What the task pays at each step, (steps, n); 0 after an episode's end.
        running: Whether the step belongs to the episode, (steps, n).
        reached: Whether the episode ended at the target, (n,).
    """

    script: str
    states: States
    events: Float
    running: Mask
    reached: Mask

    @property
    def distances(self) -> Float:
        """End effector to target, (steps + 1, n), [m]; row 0 is the begin distance."""
        return self.states["distance"]

    @property
    def steps(self) -> Float:
        """How long each episode was, (n,)."""
        return np.asarray(self.running.sum(axis=0), np.float64)


def record_rollouts(simulator: Simulator, robot: Robot, task: Task, episodes: int) -> tuple[Rollout, ...]:
    """One rollout of each of `SCRIPTS`, in their order; starts and targets are those of every evaluation.

    Raises:
        UsageError: The robot cannot do the task.
        SimulationDiverged: The engine left the finite numbers.
    """
    task.check(robot)
    goal = goal_of(task, robot)
    if goal is not None:
        raise UsageError(
            "The scripted policies of an audit go to points that do not move, and this task asks for more (its error: "
            f"{goal.error}). Audit the reward on fd100-reach, whose steps have the same fields"
        )
    off = AutoresetMode.DISABLED
    env = ReachVectorEnv(simulator, robot, task, Unpaid(), episodes, autoreset_mode=off)
    try:
        return tuple(_record(env, script) for script in SCRIPTS)
    finally:
        env.close()


def _record(env: ReachVectorEnv, script: str) -> Rollout:
    env.reset(seed=EVALUATION_SEED)
    target = env.episodes.target.copy()
    start, rng = env.simulation.read().qpos.copy(), np.random.default_rng([EVALUATION_SEED, 2])
    actions = plan_actions(script, env.robot, env.task, start, target, rng)
    running, reached = np.ones(env.num_envs, bool), np.zeros(env.num_envs, bool)
    states, rows = [_state(env)], []
    for action in actions:
        _, paid, terminated, truncated, infos = env.step(action)
        target = env.episodes.steps.before.target.copy()  # that of the step; a task that goes on has set the next one
        states.append({**_state(env), "target": target, "distance": infos["distance"]})
        rows.append((np.where(running, paid, 0.0), running))
        reached |= running & infos["is_success"]
        running = running & ~(terminated | truncated)
        if not running.any():
            break
    return Rollout(
        script, {name: np.stack([of[name] for of in states]) for name in ARM_BEFORE}, *_stacked(rows), reached
    )


def _state(env: ReachVectorEnv) -> dict[str, NDArray[Any]]:
    """What the arms are like now; copies."""
    return {name: getattr(env.episodes, name).copy() for name in ARM_BEFORE}


def _stacked(rows: list[tuple[Any, Any]]) -> tuple[Float, Mask]:
    events, running = zip(*rows, strict=True)
    return np.stack(events), np.stack(running)
