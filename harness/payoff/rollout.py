"""Recorded rollouts of the scripted policies: the same starts and targets for all."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, TypeAlias

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from harness.arrays import Float, Float32, Mask
from harness.env import ReachVectorEnv
from harness.errors import UsageError
from harness.experiment.arm_evaluation import EVALUATION_SEED
from harness.motion import JointLimits, MoveJ
from harness.reward import Array, Carry, Steps
from harness.reward.steps import ARM_BEFORE
from harness.robot import Robot
from harness.robot.inverse_kinematics import reach_position
from harness.simulator import Simulator
from harness.task import Task, goal_of

FINISH, HOVER, CREEP, OSCILLATE, HOLD, RANDOM = SCRIPTS = ("finish", "hover", "creep", "oscillate", "hold", "random")

STOPS = MappingProxyType(
    {FINISH: (0.0, 0.0), HOVER: (1.2, 1.2), CREEP: (1.2, 1.1), OSCILLATE: (1.2, 2.4), HOLD: (math.inf, math.inf)}
)
"""Where a script goes first and where then, as distances to the target in units of epsilon.

``oscillate`` goes back and forth between the two; ``creep`` takes all the time there is from one to the other, so that
it comes nearer at every step and never arrives.
"""


class NoScriptsError(UsageError):
    """The scripted policies cannot do a task; the message says why, and what to ask instead."""


@dataclass(frozen=True, eq=False)
class JointPath:
    """Straight in joint space from a start (0) to a goal (1), for n arms at once.

    Attributes:
        robot: The arm.
        start: Joint positions at 0, (n, dof), [rad].
        change: From there to the goal, (n, dof), [rad].
        target: World frame, (n, 3), [m].
    """

    robot: Robot
    start: Float
    change: Float
    target: Float

    def distance(self, along: Float) -> Float:
        """End effector to target at the places `along`, (..., n), each in [0, 1]; [m]."""
        tip = self.robot.end_effector(self.start + along[..., None] * self.change)
        return np.asarray(np.linalg.norm(self.target - tip, axis=-1))

    def first_within(self, radius: float) -> Float:
        """The last place before the path first comes within `radius` [m] of the target, (n,); 1 where it never does."""
        grid = np.linspace(0.0, 1.0, 201)
        within = self.distance(np.repeat(grid[:, None], len(self.start), axis=1)) <= radius
        first = np.where(within.any(axis=0), within.argmax(axis=0), len(grid) - 1)
        low, high = grid[np.maximum(first - 1, 0)], grid[first]
        for _ in range(30):
            middle = (low + high) / 2.0
            inside = self.distance(middle) <= radius
            low, high = np.where(inside, low, middle), np.where(inside, middle, high)
        return np.where(within.any(axis=0), low, 1.0)


def plan_actions(
    script: str, robot: Robot, task: Task, start: Float, target: Float, rng: np.random.Generator
) -> Float32:
    """Actions of a whole episode.

    Args:
        script: One of `SCRIPTS`.
        robot: The arm.
        task: Its motion turns actions into joint targets; its horizon is the length.
        start: Joint positions at rest, (n, dof), [rad].
        target: World frame, (n, 3), [m].
        rng: What ``random`` draws from.

    Returns:
        Joint speeds as fractions of their maxima, (horizon, n, dof), in [-1, 1].

    Raises:
        NoScriptsError: The task's actions are no joint speeds.
    """
    motion = task.motion(robot)
    if not isinstance(motion, MoveJ):
        raise NoScriptsError("The scripted policies of an audit move joints: name a task with action=movej")
    if script == RANDOM:
        return rng.uniform(-1.0, 1.0, (task.horizon, *start.shape)).astype(np.float32)
    path = JointPath(robot, start, _pose_at(robot, target, start) - start, target)
    first, second = (path.first_within(stop * task.epsilon) for stop in STOPS[script])
    speeds = _speeds_along(path, motion.limits, first, second, task.horizon)
    actions: Float32 = (speeds[:, :, None] * path.change / motion.limits.max_speed).astype(np.float32)
    return actions


def _pose_at(robot: Robot, target: Float, start: Float) -> Float:
    """Joint positions at the target, (n, dof): near the start's where the search from there succeeds."""
    near, found = reach_position(robot, target, start)
    other, _ = reach_position(robot, target, np.tile(robot.home, (len(start), 1)))
    return np.where(found[:, None], near, other)


def _speeds_along(path: JointPath, limits: JointLimits, first: Float, second: Float, steps: int) -> Float:
    """Speeds along the path, (steps, n), [1/s]: at full speed to the place `first`, on to `second`, and back again.

    Where `second` is behind, at full speed too; where it is ahead, so slowly that it is not reached.
    """
    there = _limits_along(path, limits, np.zeros_like(first), first)
    on = _limits_along(path, limits, np.minimum(first, second), np.maximum(first, second))
    creep = (second - first) / ((steps + 1) * limits.period)
    wanted = np.where(second > first, np.minimum(creep, on.max_speed), -on.max_speed)
    place = speed = np.zeros((1, len(first)))
    going_there = np.ones(place.shape, bool)
    speeds = np.empty((steps, len(first)))
    for step in range(steps):
        legs = there.advance(place, speed, there.max_speed[None]), on.advance(place, speed, wanted[None])
        place, speed = (np.where(going_there, one, other) for one, other in zip(*legs, strict=True))
        speeds[step] = speed
        going_there ^= np.abs(speed) <= 1e-9 * there.max_speed  # it has stopped: at an end
    return speeds


def _limits_along(path: JointPath, limits: JointLimits, lower: Float, upper: Float) -> JointLimits:
    """The arm's limits as those of one number, the place on the path; the n arms take the place of joints.

    On the path all joints keep step, so the one that is nearest to a limit sets the pace.
    """
    size = np.maximum(np.abs(path.change), 1e-9)
    speed, change = (limits.max_speed / size).min(axis=1), (limits.max_change / size).min(axis=1)
    return JointLimits(lower, upper, speed, change, limits.period)


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


def record_rollouts(
    simulator: Simulator, robot: Robot, task: Task, episodes: int, noise: float = 0.0
) -> tuple[Rollout, ...]:
    """One rollout of each of `SCRIPTS`, in their order; starts and targets are those of every evaluation.

    Args:
        simulator: Moves the arms.
        robot: The arm.
        task: What it has to do.
        episodes: Of each script.
        noise: The standard deviation of what is added to every action, before it is clipped to [-1, 1].

    Raises:
        UsageError: The robot cannot do the task; a `NoScriptsError` if only the scripts cannot.
        SimulationDiverged: The engine left the finite numbers.
    """
    task.check(robot)
    goal = goal_of(task, robot)
    if goal is not None:
        raise NoScriptsError(
            "The scripted policies of an audit go to points that do not move, and this task asks for more (its error: "
            f"{goal.error}). Audit the reward on fd100-reach, whose steps have the same fields"
        )
    off = AutoresetMode.DISABLED
    env = ReachVectorEnv(simulator, robot, task, Unpaid(), episodes, autoreset_mode=off)
    try:
        return tuple(_record(env, script, noise) for script in SCRIPTS)
    finally:
        env.close()


def _record(env: ReachVectorEnv, script: str, noise: float) -> Rollout:
    env.reset(seed=EVALUATION_SEED)
    target = env.episodes.target.copy()
    start, rng = env.simulation.read().qpos.copy(), np.random.default_rng([EVALUATION_SEED, 2])
    actions = plan_actions(script, env.robot, env.task, start, target, rng)
    if noise:
        actions = np.clip(actions + noise * rng.standard_normal(actions.shape, np.float32), -1.0, 1.0)
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
