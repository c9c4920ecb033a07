"""The simulator."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harness.kinematics import forward
from harness.robot import Robot
from harness.simulator import Float, State
from harness.solids import build_solids
from harness.substeps import Substeps
from harness.urdf import Joint  # noqa: F401 # a type that authors used


@dataclass(frozen=True)
class Still:
    """Joints stand where they are told, at once."""

    steps: int = 20

    def open(self, robot: Robot, num_envs: int, control_period: float) -> "StillSimulation":
        """See `harness.simulator.Simulator`."""
        return StillSimulation(robot, num_envs, Substeps(self.steps, control_period))


class StillSimulation:
    """See `harness.simulator.Simulation`."""

    def __init__(self, robot: Robot, num_envs: int, substeps: Substeps) -> None:
        self._robot, self._substeps = robot, substeps
        self._solids = build_solids([])
        self._qpos, self._qvel = np.tile(robot.home, (num_envs, 1)), np.zeros((num_envs, robot.dof))

    def reset(self, qpos: Float, mask: NDArray[np.bool_]) -> State:
        """Put some there."""
        self._qpos[mask], self._qvel[mask] = qpos[mask], 0.0
        return self.read()

    def drive(self, qpos: Float, duration: float) -> State:
        """Be there."""
        self._substeps.within(duration)
        self._qvel = (qpos - self._qpos) / duration
        self._qpos = qpos.copy()
        return self.read()

    def place(self, qpos: Float) -> State:
        """Put all there."""
        self._qpos, self._qvel = qpos.copy(), np.zeros_like(self._qvel)
        return self.read()

    def read(self) -> State:
        """The state."""
        tip = forward(self._robot.chain, self._qpos)[..., :3, 3]
        return State(self._qpos.copy(), self._qvel.copy(), tip, np.zeros(len(tip), bool))

    def render(self, env: int, target: Float, width: int, height: int) -> NDArray[np.uint8]:
        """A frame of nothing."""
        return np.full((height, width, 3), 255, np.uint8)

    def close(self) -> None:
        """Nothing is open."""
