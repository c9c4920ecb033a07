"""Inverse kinematics: joint positions that bring the end effector to a point, or to a pose."""

from typing import Protocol

import numpy as np

from harness.arrays import Float, Mask
from harness.robot.kinematics import (
    Chain,
    child_frames,
    forward,
    pose_jacobian,
    position_jacobian_of,
    rotation_between,
    tip_position,
)

DAMPING = 0.05
"""The damping of the least squares, [m]: small beside an arm's reach, large enough to pass a singular pose."""

POSE_DAMPING = 0.02
"""The same where the orientation counts too: a turn's lever is shorter."""

STRIDE = 0.15
"""The most of one step, as a share of the arm's reach: the Jacobian says nothing about far away, and arms overshoot."""


LEVER = 0.1
"""What a turn counts beside a way, [m/rad]: about as long as a hand."""


class Arm(Protocol):
    """What the search has to know; `harness.robot.robot.Robot` says what each means."""

    @property
    def chain(self) -> Chain:
        """The joints."""

    @property
    def lower(self) -> Float:
        """Smallest joint positions, (dof,)."""

    @property
    def upper(self) -> Float:
        """Largest joint positions, (dof,)."""

    @property
    def reach(self) -> float:
        """No end effector position is farther from the first joint's origin [m]."""


def reach_position(
    robot: Arm, position: Float, start: Float, tolerance: float = 1e-3, iterations: int = 60
) -> tuple[Float, Mask]:
    """Joint positions within the ranges whose end effector is at `position`, by damped least squares.

    Args:
        robot: The arm.
        position: World frame, (n, 3), [m].
        start: Where the search begins, (n, dof).
        tolerance: How close is there, [m].
        iterations: How many steps the search may take.

    Returns:
        Joint positions (n, dof), and whether each one is there, (n,). A False is no proof that none exists.
    """
    chain, qpos = robot.chain, np.array(start, dtype=np.float64)
    damping = DAMPING**2 * np.eye(3)
    for left in range(iterations, -1, -1):
        frames = child_frames(chain, qpos)
        error = position - tip_position(chain, frames)
        distance = np.linalg.norm(error, axis=-1, keepdims=True)
        if not left or (distance <= tolerance).all():
            break
        error *= np.minimum(1.0, STRIDE * robot.reach / np.maximum(distance, tolerance))
        jacobian = position_jacobian_of(chain, frames)
        transposed = np.swapaxes(jacobian, -1, -2)
        step = (transposed @ np.linalg.solve(jacobian @ transposed + damping, error[..., None]))[..., 0]
        qpos = np.minimum(np.maximum(qpos + step, robot.lower), robot.upper)
    return qpos, distance[..., 0] <= tolerance


def reach_pose(
    robot: Arm,
    position: Float,
    rotation: Float,
    start: Float,
    tolerance: float = 1e-3,
    angle_tolerance: float = 1e-2,
    iterations: int = 60,
) -> tuple[Float, Mask]:
    """The same as `reach_position`, with the orientation: a turn of 1 rad counts as much as a way of `LEVER`.

    Args:
        robot: The arm.
        position: World frame, (n, 3), [m].
        rotation: Of the end effector's link in the world frame, (n, 3, 3).
        start: Where the search begins, (n, dof).
        tolerance: How close is there, [m].
        angle_tolerance: How small an angle is there, [rad].
        iterations: How many steps the search may take.

    Returns:
        Joint positions (n, dof), and whether each one is there, (n,). A False is no proof that none exists.
    """
    qpos, weights = np.array(start, dtype=np.float64), np.repeat([1.0, LEVER], 3)
    for _ in range(iterations):
        error = _pose_error(robot, position, rotation, qpos)
        if _is_there(error, tolerance, angle_tolerance).all():
            break
        error *= weights
        size = np.linalg.norm(error, axis=-1, keepdims=True)
        error *= np.minimum(1.0, STRIDE * robot.reach / np.maximum(size, tolerance))
        jacobian = weights[:, None] * pose_jacobian(robot.chain, qpos)
        transposed = np.swapaxes(jacobian, -1, -2)
        damped = jacobian @ transposed + POSE_DAMPING**2 * np.eye(6)
        step = (transposed @ np.linalg.solve(damped, error[..., None]))[..., 0]
        qpos = np.minimum(np.maximum(qpos + step, robot.lower), robot.upper)
    return qpos, _is_there(_pose_error(robot, position, rotation, qpos), tolerance, angle_tolerance)


def _pose_error(robot: Arm, position: Float, rotation: Float, qpos: Float) -> Float:
    """Way and turn that are left, (n, 6), [m] and [rad]."""
    pose = forward(robot.chain, qpos)
    return np.concatenate([position - pose[:, :3, 3], rotation_between(pose[:, :3, :3], rotation)], axis=1)


def _is_there(error: Float, tolerance: float, angle_tolerance: float) -> Mask:
    way, turn = (np.linalg.norm(part, axis=-1) for part in (error[:, :3], error[:, 3:]))
    there: Mask = (way <= tolerance) & (turn <= angle_tolerance)
    return there
