"""Computes what the actuators of a model from `build_model` are fed during a drive."""

import numpy as np

from harness.arrays import Float, Mask
from harness.authoring.servo_track import ServoTrack
from harness.robot.servo import Servo


class RampFeed:
    """Computes the controls of ideal drives: the joints' speeds twice, the same in all physics steps.

    Args:
        held: What the integrating actuators hold, (num_envs, dof); a view.
        controls: Where the speeds are written, (num_envs, 1, 2 dof).
    """

    def __init__(self, held: Float, controls: Float) -> None:
        self._held, self._controls = held, controls
        self._speeds = controls.reshape(len(held), 2, held.shape[1])

    def reset(self, qpos: Float, mask: Mask) -> None:
        """Does nothing: the actuators hold the pose already."""

    def controls(self, qpos: Float, duration: float, steps: int) -> Float:
        """The controls that lead to `qpos`, (num_envs, dof), in `duration` [s]; (num_envs, 1, 2 dof)."""
        # The speeds lead from the positions that the servos hold now, so rounding cannot add up over periods.
        speeds = qpos - self._held
        speeds /= duration
        self._speeds[...] = speeds[:, None]
        return self._controls


class ServoFeed:
    """Computes the controls of drives with limits: in each physics step, the torque that the references alone cause.

    Args:
        servo: The drives.
        num_envs: How many arms.
        timestep: A physics step, [s].
    """

    def __init__(self, servo: Servo, num_envs: int, timestep: float) -> None:
        self._servo, self._track = servo, ServoTrack(servo, num_envs, timestep)

    def reset(self, qpos: Float, mask: Mask) -> None:
        """Begin new references for the arms of `mask`, (num_envs,), which were put at `qpos`, (num_envs, dof)."""
        self._track.reset(qpos, mask)

    def controls(self, qpos: Float, duration: float, steps: int) -> Float:
        """The controls that lead to `qpos`, (num_envs, dof), for `duration` [s]: (num_envs, steps, dof), [N m]."""
        position, speed = self._track.advance(qpos, duration, steps)
        wanted = self._servo.stiffness * position + self._servo.damping * speed
        return np.ascontiguousarray(wanted.swapaxes(0, 1))
