"""A simulation of arms whose drives have limits, for engines that step one arm at a time."""

from collections.abc import Callable
from typing import Protocol

import numpy as np

from harness import Float, Mask
from harness.robot import Robot
from harness.simulator import ServoTrack, State, Substeps, servo_of

from .apart import ArmAlone, Arms, Frames


class ServoArm(ArmAlone, Protocol):
    """One arm that is moved by the drives of its robot.toml, `harness.robot.joint_limits.Servo`."""

    def follow(self, qpos_ref: Float, qvel_ref: Float) -> None:
        """Do one physics step for each row of the references.

        Args:
            qpos_ref: The positions to follow, (steps, dof), [rad] or [m].
            qvel_ref: The speeds to follow, (steps, dof), [rad/s] or [m/s].
        """


class ServoArms(Arms[ServoArm]):
    """Arms whose drives follow a reference in each physics step; see `harness.simulator.Simulation`."""

    def __init__(
        self,
        robot: Robot,
        num_envs: int,
        substeps: Substeps,
        build_arm: Callable[[], ServoArm],
        frames: Frames | None = None,
    ) -> None:
        """Build the arms and put them at home.

        Args:
            robot: The arm.
            num_envs: How many arms.
            substeps: The physics steps of a control period.
            build_arm: Makes an arm in a new world.
            frames: Draws the frames; by default the harness does.

        Raises:
            UsageError: The robot.toml describes no drives.
        """
        self._substeps = substeps
        self.track = ServoTrack(servo_of(robot), num_envs, substeps.period / substeps.count)
        super().__init__(robot, num_envs, build_arm, frames)

    def reset(self, qpos: Float, mask: Mask) -> State:
        self.track.reset(qpos, mask)
        return super().reset(qpos, mask)

    def drive(self, qpos: Float, duration: float) -> State:
        told = self.track.advance(qpos, duration, self._substeps.within(duration))
        for k in np.flatnonzero(self._awake).tolist():
            self.arms[k].follow(told.qpos[:, k], told.qvel[:, k])
            self.arms[k].read(self._state, k)
        return self._state
