"""Inverse kinematics: joint positions that bring the end effector to a point."""

from typing import Protocol

import numpy as np

from harness.arrays import Float, Mask

DAMPING = 0.05
"""Of the least squares, [m]: small beside an arm's reach, large enough to pass a singular pose."""

STRIDE = 0.15
"""Of one step, as a share of the arm's reach: the Jacobian says nothing about far away, and arms overshoot."""


class Arm(Protocol):
    """What the search has to know; `harness.robot.robot.Robot` says what each means."""

    @property
    def lower(self) -> Float:
        """Smallest joint positions, (dof,)."""

    @property
    def upper(self) -> Float:
        """Largest joint positions, (dof,)."""

    @property
    def reach(self) -> float:
        """No end effector position is farther from the first joint's origin [m]."""

    def end_effector(self, qpos: Float) -> Float:
        """Its position in the world frame, (n, 3) of (n, dof)."""

    def jacobian(self, qpos: Float) -> Float:
        """The derivative of that by the joint positions, (n, 3, dof)."""


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
    qpos = np.array(start, dtype=np.float64)
    for _ in range(iterations):
        error = position - robot.end_effector(qpos)
        distance = np.linalg.norm(error, axis=-1, keepdims=True)
        if (distance <= tolerance).all():
            break
        error *= np.minimum(1.0, STRIDE * robot.reach / np.maximum(distance, tolerance))
        jacobian = robot.jacobian(qpos)
        transposed = np.swapaxes(jacobian, -1, -2)
        damped = jacobian @ transposed + DAMPING**2 * np.eye(3)
        step = (transposed @ np.linalg.solve(damped, error[..., None]))[..., 0]
        qpos = np.minimum(np.maximum(qpos + step, robot.lower), robot.upper)
    error = position - robot.end_effector(qpos)
    return qpos, np.linalg.norm(error, axis=-1) <= tolerance
