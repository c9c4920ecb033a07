"""A simulator without an engine: joints are where they are told to be, exactly."""

from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Mask
from harness.errors import UsageError
from harness.robot import Robot
from harness.robot.ground_clearance import build_solids
from harness.robot.kinematics import child_frames, link_frames
from harness.simulator import State


@dataclass(frozen=True)
class IdealSimulator:
    """No dynamics and no delay. The ground is touched by a solid, or where the end effector or a joint is at z <= 0."""

    def open(self, robot: Robot, num_envs: int, control_period: float) -> "IdealSimulation":
        return IdealSimulation(robot, num_envs)


class IdealSimulation:
    """See `harness.simulator.Simulation`. Each call returns arrays of its own.

    Attributes:
        robot: The arm.
        qpos: Joint positions, (num_envs, dof), [rad].
        qvel: Joint velocities, (num_envs, dof), [rad/s].
    """

    def __init__(self, robot: Robot, num_envs: int) -> None:
        self.robot, self._solids = robot, build_solids(robot.joint_shapes)
        self.qpos = np.tile(robot.home, (num_envs, 1))
        self.qvel = np.zeros_like(self.qpos)
        self._asleep, self._awake = np.zeros(num_envs, bool), cast(NDArray[np.intp] | slice, slice(None))
        self._tip, self._contact = np.zeros((num_envs, 3)), np.zeros(num_envs, bool)

    def reset(self, qpos: Float, mask: Mask) -> State:
        self.qpos[mask], self.qvel[mask] = qpos[mask], 0.0
        self._let_sleep(self._asleep & ~mask)
        return self.state()

    def drive(self, qpos: Float, duration: float) -> State:
        self.qvel[:] = (qpos - self.qpos) / duration
        self.qpos[:] = qpos
        return self.state()

    def place(self, qpos: Float) -> State:
        self.qpos[:], self.qvel[:] = qpos, 0.0
        return self.state()

    def read(self) -> State:
        return self.state()

    def rest(self, mask: Mask) -> None:
        """Compute nothing of the arms of `mask`, (num_envs,), until they are reset or another mask is given."""
        self._let_sleep(mask)

    def _let_sleep(self, mask: Mask) -> None:
        self._asleep, self._awake = mask.copy(), np.flatnonzero(~mask) if mask.any() else slice(None)

    def state(self) -> State:
        """What every call tells."""
        qpos = self.qpos[self._awake]
        frames = child_frames(self.robot.chain, qpos)
        tip = (frames[-1] @ self.robot.chain.T_last_tip)[:, :3, 3]
        heights = [tip[:, 2], *(frame[:, 2, 3] for frame in frames[1:])]  # the first joint's origin stands still
        contact = (np.min(heights, axis=0) <= 0.0) | self._solids.touch_ground(link_frames(self.robot.chain, qpos))
        self._tip[self._awake], self._contact[self._awake] = tip, contact
        return State(self.qpos.copy(), self.qvel.copy(), self._tip.copy(), self._contact.copy())

    def render(self, env: int, target: Float, width: int, height: int) -> NDArray[np.uint8]:
        """Raises UsageError, always."""
        raise UsageError("The ideal simulator has no renderer: take another simulator to see the arm")

    def close(self) -> None:
        """Does nothing: there is no engine."""
