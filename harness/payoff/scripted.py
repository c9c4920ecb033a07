"""Scripted policies: what an arm can do without having learned anything.

All but ``random`` move along one path, straight in joint space from the start to a pose at the target that inverse
kinematics finds, and differ in where on it they stop and turn.
"""

import math
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from harness.arrays import Float, Float32
from harness.errors import UsageError
from harness.motion import JointLimits, MoveJ
from harness.robot import Robot
from harness.robot.inverse_kinematics import reach_position
from harness.task import Task

FINISH, HOVER, CREEP, OSCILLATE, HOLD, RANDOM = SCRIPTS = ("finish", "hover", "creep", "oscillate", "hold", "random")

STOPS = MappingProxyType(
    {FINISH: (0.0, 0.0), HOVER: (1.2, 1.2), CREEP: (1.2, 1.1), OSCILLATE: (1.2, 2.4), HOLD: (math.inf, math.inf)}
)
"""Where a script goes first and where then, as distances to the target in units of epsilon.

``oscillate`` goes back and forth between the two; ``creep`` takes all the time there is from one to the other, so that
it comes nearer at every step and never arrives.
"""


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
        UsageError: The task's actions are no joint speeds.
    """
    motion = task.motion(robot)
    if not isinstance(motion, MoveJ):
        raise UsageError("The scripted policies of an audit move joints: name a task with action=movej")
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
