"""What the actuators of a model by `build_model` are fed along a drive."""

import numpy as np

from harness.arrays import Float, Mask
from harness.authoring.servo_track import ServoTrack
from harness.robot.servo import Servo


class RampFeed:
    """Of ideal drives: the joints' speeds twice, the same in all physics steps.

    Args:
        held: What the integrating actuators hold, (num_envs, dof); a view.
        controls: Where the speeds are written, (num_envs, 1, 2 dof).
    """

    def __init__(self, held: Float, controls: Float) -> None:
        self._held, self._controls = held, controls
        self._speeds = controls.reshape(len(held), 2, held.shape[1])

    def reset(self, qpos: Float, mask: Mask) -> None:
        """The actuators hold the pose already."""

    def controls(self, qpos: Float, duration: float, steps: int) -> Float:
        """Of the physics steps to `qpos`, (num_envs, dof), (num_envs, 1, 2 dof)."""
        # From where the servos hold now to the target: rounding cannot add up over periods.
        speeds = qpos - self._held
        speeds /= duration
        self._speeds[...] = speeds[:, None]
        return self._controls


class ServoFeed:
    """Of drives with limits: what the references alone make the torques, in each physics step.

    Args:
        servo: The drives.
        num_envs: How many arms.
        timestep: A physics step, [s].
    """

    def __init__(self, servo: Servo, num_envs: int, timestep: float) -> None:
        self._servo, self._track = servo, ServoTrack(servo, num_envs, timestep)

    def reset(self, qpos: Float, mask: Mask) -> None:
        """The arms of `mask`, (num_envs,), have been put at `qpos`, (num_envs, dof)."""
        self._track.reset(qpos, mask)

    def controls(self, qpos: Float, duration: float, steps: int) -> Float:
        """Of the physics steps to `qpos`, (num_envs, dof), (num_envs, steps, dof), [N m]."""
        position, speed = self._track.advance(qpos, duration, steps)
        wanted = self._servo.stiffness * position + self._servo.damping * speed
        return np.ascontiguousarray(wanted.swapaxes(0, 1))
