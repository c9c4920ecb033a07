"""Arms whose drives have limits, each in a world of its own, for simulators that step one arm."""

from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np

from harness.arrays import Float, Mask
from harness.authoring.servo_track import ServoTrack, servo_of
from harness.authoring.substeps import Substeps
from harness.robot import Robot
from harness.simulator import State

from .apart import ArmAlone, Arms, Frames


class ServoArm(ArmAlone, Protocol):
    """One arm that is moved by the drives of its robot.toml, `harness.robot.servo.Servo`."""

    def follow(self, qpos_ref: Float, qvel_ref: Float) -> None:
        """A physics step for each row of the references, (steps, dof), [rad] or [m] and per second."""


class ServoArms(Arms[ServoArm]):
    """See `harness.simulator.Simulation`: each physics step the drives follow a reference of their own."""

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
            num_envs: How many.
            substeps: Of a control period.
            build_arm: Makes one, in a new world.
            frames: Pictures of it; by default the harness draws them.

        Raises:
            UsageError: The robot.toml describes no drives.
        """
        self._substeps = substeps
        self.track = ServoTrack(servo_of(robot), num_envs, substeps.period / substeps.count)
        super().__init__(robot, num_envs, build_arm, frames)

    def reset(self, qpos: Float, mask: Mask) -> State:
        """See `harness.simulator.Simulation`."""
        self.track.reset(qpos, mask)
        return super().reset(qpos, mask)

    def drive(self, qpos: Float, duration: float) -> State:
        """See `harness.simulator.Simulation`."""
        told = self.track.advance(qpos, duration, self._substeps.within(duration))
        for k in np.flatnonzero(self._awake).tolist():
            self.arms[k].follow(told.qpos[:, k], told.qvel[:, k])
            self.arms[k].read(self._state, k)
        return self._state


class FollowingArms(Protocol):
    """A simulation of such arms."""

    @property
    def arms(self) -> Sequence[ServoArm]:
        """In order."""

    @property
    def track(self) -> ServoTrack:
        """What they follow."""

    def place(self, qpos: Float) -> State:
        """See `harness.simulator.Simulation`."""


def follow_alone(simulation: FollowingArms, targets: Float, period: float, substeps: int) -> Callable[[], None]:
    """See `harness.simulator.Simulator`, its ``bare_loop``: the arms follow and are read by the engine's own calls.

    The references are computed before; the torques are not, since they follow from the state in each physics step.
    """
    state = simulation.place(targets[-1])
    told = [simulation.track.advance(qpos, period, substeps) for qpos in targets]

    def run() -> None:
        for qpos_ref, qvel_ref in told:
            for k, arm in enumerate(simulation.arms):
                arm.follow(qpos_ref[:, k], qvel_ref[:, k])
                arm.read(state, k)

    return run
