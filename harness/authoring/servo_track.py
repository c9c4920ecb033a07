"""The motion that drives with limits follow in each physics step, for simulators with `drive=servo`."""

from typing import NamedTuple

import numpy as np

from harness.arrays import Float, Mask
from harness.robot.joint_limits import Servo
from harness.simulator import servo_of

__all__ = ["References", "ServoTrack", "servo_of"]


class References(NamedTuple):
    """What the drives have to follow in each of several physics steps, in order. The arrays are new."""

    qpos: Float
    """Positions, shape (steps, num_envs, dof), [rad] or [m]."""
    qvel: Float
    """Speeds, shape (steps, num_envs, dof), [rad/s] or [m/s]."""


class ServoTrack:
    """The references of a batch of arms, delayed by the latency of their drives; see `harness.robot.Servo`."""

    def __init__(self, servo: Servo, num_envs: int, timestep: float) -> None:
        """All arms rest at zero until they are reset.

        Args:
            servo: The drives, dof of them.
            num_envs: How many arms.
            timestep: A physics step, [s].
        """
        self._target = np.zeros((num_envs, len(servo.max_torque)))
        """Commanded last."""
        self._coming = np.zeros((servo.delay(timestep), 2, *self._target.shape))
        """Positions and speeds that are commanded and that the drives do not follow yet; one row per physics step."""

    def reset(self, qpos: Float, mask: Mask) -> None:
        """Put the arms in `mask`, (num_envs,), at rest at `qpos`, (num_envs, dof), and drop their earlier commands."""
        self._target[mask] = qpos[mask]
        self._coming[:, 0, mask], self._coming[:, 1, mask] = qpos[mask], 0.0

    def advance(self, qpos: Float, duration: float, steps: int) -> References:
        """Command a motion at constant speed from the last targets to `qpos`.

        Args:
            qpos: The new targets, shape (num_envs, dof), [rad] or [m].
            duration: Duration of the motion, [s].
            steps: How many physics steps it has, >= 1.

        Returns:
            What the drives have to follow in the next `steps` physics steps. Each row holds at the beginning of a step.
        """
        way = qpos - self._target
        ramp = np.empty((steps, 2, *qpos.shape))
        ramp[:, 0] = self._target + np.arange(steps)[:, None, None] / steps * way
        ramp[:, 1] = way / duration
        self._target[...] = qpos
        told = np.concatenate([self._coming, ramp])
        self._coming = told[steps:]
        return References(told[:steps, 0], told[:steps, 1])
