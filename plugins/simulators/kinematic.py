"""No dynamics: joints are exactly where they are driven, and ground contact is that of the links' shapes."""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic.dataclasses import dataclass

from harness import Float, Mask
from harness.robot import Robot, build_solids, link_frames
from harness.simulator import State, StillFrames


@dataclass(frozen=True)
class Kinematic:
    """Arms without mass: they move without delay and error, and the ground exerts no force.

    Ground contact is exact for the moving links' collision shapes: boxes, cylinders, capsules, spheres and meshes.
    Without dynamics there are no drives to simulate, and links pass through one another. So this simulator has neither
    `drive` nor `self_collision`.
    """

    family: ClassVar[str | None] = None

    def open(self, robot: Robot, num_envs: int, control_period: float) -> "KinematicSimulation":
        return KinematicSimulation(robot, num_envs)


class KinematicSimulation:
    """See `harness.simulator.Simulation`."""

    def __init__(self, robot: Robot, num_envs: int) -> None:
        self._frames, self._chain = StillFrames(robot), robot.chain
        self._solids = build_solids(robot.joint_shapes)
        joints = (num_envs, robot.dof)
        self._state = State(np.zeros(joints), np.zeros(joints), np.zeros((num_envs, 3)), np.zeros(num_envs, bool))
        self.reset(np.tile(robot.home, (num_envs, 1)), np.ones(num_envs, bool))

    def reset(self, qpos: Float, mask: Mask) -> State:
        state = self._state
        arms = np.flatnonzero(mask)
        state.qpos[arms], state.qvel[arms] = qpos[arms], 0.0
        state.end_effector[arms], state.ground_contact[arms] = self._place_links(state.qpos[arms])
        return state

    def place(self, qpos: Float) -> State:
        if np.array_equal(qpos, self._state.qpos):  # a decision of several steps puts the arms where they are
            self._state.qvel[...] = 0.0
            return self._state
        return self.reset(qpos, np.ones(len(qpos), bool))

    def drive(self, qpos: Float, duration: float) -> State:
        state = self._state
        np.subtract(qpos, state.qpos, out=state.qvel)
        state.qvel[...] /= duration
        state.qpos[...] = qpos
        state.end_effector[...], state.ground_contact[...] = self._place_links(state.qpos)
        return state

    def read(self) -> State:
        return self._state

    def render(self, env: int, target: Float, width: int, height: int) -> NDArray[np.uint8]:
        """See `harness.simulator.Simulation`; drawn without an engine."""
        return self._frames.frame(self._state.qpos[env], target, width, height)

    def close(self) -> None:
        """Does nothing: there is no engine."""

    def _place_links(self, qpos: Float) -> tuple[Float, Mask]:
        """End effectors, (n, 3), [m], and ground contacts, (n,), of arms at `qpos`, (n, dof)."""
        frames = link_frames(self._chain, qpos)
        x, y, z = self._chain.T_last_tip[:3, 3]
        last = frames[-1]
        tip = last[:, 0] * x + last[:, 1] * y + last[:, 2] * z + last[:, 3]
        return tip.T, self._solids.touch_ground(frames)
