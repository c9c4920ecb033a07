"""A simulation without its physics, for engines that step one arm at a time. Each arm has a world of its own."""

from collections.abc import Callable
from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from harness import Float, Mask
from harness.robot import Robot
from harness.simulator import State, StillFrames


class ArmAlone(Protocol):
    """One arm on the ground, alone in its world."""

    def put(self, qpos: Float) -> None:
        """Put the arm at rest at `qpos`, (dof,), as if the world were new, contacts included."""

    def read(self, state: State, env: int) -> None:
        """Write the present state of the arm into row `env` of `state`."""


class Arm(ArmAlone, Protocol):
    """An arm that is driven at constant speeds."""

    def turn(self, speeds: Float, duration: float) -> None:
        """Drive each joint at its constant speed, (dof,), [rad/s] or [m/s], for `duration` [s]."""


AnyArm = TypeVar("AnyArm", bound=ArmAlone)


class Frames(Protocol):
    """Draws frames of an arm."""

    def frame(self, qpos: Float, target: Float, width: int, height: int) -> NDArray[np.uint8]:
        """The arm at `qpos`, (dof,), and a marker at `target`, (3,), [m]; RGB, (height, width, 3)."""

    def close(self) -> None:
        """Release what the frames need, and the arms' worlds; a second call does nothing."""


class Arms(Generic[AnyArm]):
    """Everything of `harness.simulator.Simulation` except `drive`."""

    def __init__(
        self, robot: Robot, num_envs: int, build_arm: Callable[[], AnyArm], frames: Frames | None = None
    ) -> None:
        """Build the arms and put them at home.

        Args:
            robot: The arm.
            num_envs: How many arms.
            build_arm: Makes an arm in a new world.
            frames: Draws the frames; by default the harness does.
        """
        self.arms = [build_arm() for _ in range(num_envs)]
        self._frames = frames or StillFrames(robot)
        self._awake = np.ones(num_envs, bool)
        joints = (num_envs, robot.dof)
        self._state = State(np.zeros(joints), np.zeros(joints), np.zeros((num_envs, 3)), np.zeros(num_envs, bool))
        self.place(np.tile(robot.home, (num_envs, 1)))

    def reset(self, qpos: Float, mask: Mask) -> State:
        self._awake |= mask
        for k in np.flatnonzero(mask).tolist():
            self.arms[k].put(qpos[k])
            self.arms[k].read(self._state, k)
        return self._state

    def place(self, qpos: Float) -> State:
        return self.reset(qpos, np.ones(len(self.arms), bool))

    def rest(self, mask: Mask) -> None:
        self._awake = ~mask

    def read(self) -> State:
        return self._state

    def render(self, env: int, target: Float, width: int, height: int) -> NDArray[np.uint8]:
        return self._frames.frame(self._state.qpos[env], target, width, height)

    def close(self) -> None:
        self.arms = []
        self._frames.close()


class ArmsApart(Arms[Arm]):
    """Arms that are driven at constant speeds; see `harness.simulator.Simulation`.

    In each period a joint gets the constant speed that leads from its present position to its target. If it misses the
    target in one period, it makes up for that in the next.
    """

    def drive(self, qpos: Float, duration: float) -> State:
        speeds = (qpos - self._state.qpos) / duration
        for k in np.flatnonzero(self._awake).tolist():
            self.arms[k].turn(speeds[k], duration)
            self.arms[k].read(self._state, k)
        return self._state
