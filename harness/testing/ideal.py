"""A simulator without an engine, for tests: joints are where they are told to be, exactly."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Mask
from harness.errors import UsageError
from harness.robot import Robot
from harness.robot.kinematics import Chain, end_effector_position
from harness.simulator import State


@dataclass(frozen=True)
class IdealSimulator:
    """No dynamics and no delay. The ground is touched when the end effector or a joint's origin is at z <= 0."""

    def open(self, robot: Robot, num_envs: int, control_period: float) -> "IdealSimulation":
        """See `harness.simulator.Simulator`."""
        return IdealSimulation(robot, num_envs)


class IdealSimulation:
    """See `harness.simulator.Simulation`. Each call returns arrays of its own.

    Attributes:
        robot: The arm.
        qpos: Joint positions, (num_envs, dof), [rad].
        qvel: Joint velocities, (num_envs, dof), [rad/s].
    """

    def __init__(self, robot: Robot, num_envs: int) -> None:
        self.robot = robot
        # The first joint's origin stands still.
        self._parts = [_first_joints(robot.chain, count) for count in range(2, robot.dof + 1)]
        self.qpos = np.tile(robot.home, (num_envs, 1))
        self.qvel = np.zeros_like(self.qpos)

    def reset(self, qpos: Float, mask: Mask) -> State:
        """See `harness.simulator.Simulation`."""
        self.qpos[mask], self.qvel[mask] = qpos[mask], 0.0
        return self.state()

    def drive(self, qpos: Float, duration: float) -> State:
        """See `harness.simulator.Simulation`."""
        self.qvel[:] = (qpos - self.qpos) / duration
        self.qpos[:] = qpos
        return self.state()

    def place(self, qpos: Float) -> State:
        """See `harness.simulator.Simulation`."""
        return self.reset(qpos, np.ones(len(qpos), bool))

    def read(self) -> State:
        """See `harness.simulator.Simulation`."""
        return self.state()

    def state(self) -> State:
        """What every call tells."""
        tip = self.robot.end_effector(self.qpos)
        heights = [end_effector_position(part, self.qpos[:, : part.dof])[:, 2] for part in self._parts]
        return State(self.qpos.copy(), self.qvel.copy(), tip, np.min([tip[:, 2], *heights], axis=0) <= 0.0)

    def render(self, env: int, target: Float, width: int, height: int) -> NDArray[np.uint8]:
        """Raises UsageError, always."""
        raise UsageError("The ideal simulator has no renderer: take another simulator to see the arm")

    def close(self) -> None:
        """Does nothing: there is no engine."""


def _first_joints(chain: Chain, count: int) -> Chain:
    """The first `count` joints, with the last one's origin as the tip."""
    return Chain(chain.T_previous_joint[:count], chain.axes[:count], chain.kinds[:count], np.eye(4))
