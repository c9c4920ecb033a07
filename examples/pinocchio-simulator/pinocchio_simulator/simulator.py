"""Rigid bodies by pinocchio: forward dynamics by the articulated body algorithm (ABA), one arm after the other."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import pinocchio
from numpy.typing import NDArray
from pydantic import Field

from harness import Float, Mask
from harness.robot import Robot
from harness.simulator import GroundContact, State, StillFrames, Substeps


@dataclass(frozen=True)
class Pinocchio:
    """Arms with mass whose drives track a joint ramp; the ground is seen, not felt.

    A drive's torque is g(q) + M(q) (w^2 e + 2 w e'), with the errors e and e' of the joint's position and speed:
    gravity is made up for, coupling by speed is not. Contact is exact for the links' shapes, and nothing pushes back:
    in the harness's tasks it ends the episode.
    """

    substeps: Annotated[int, Field(gt=0, description="physics steps per control period")] = 20
    bandwidth: Annotated[float, Field(gt=0, description="bandwidth of the joint drives, w [rad/s]")] = 60.0

    def open(self, robot: Robot, num_envs: int, control_period: float) -> "PinocchioSimulation":
        return PinocchioSimulation(self, robot, num_envs, control_period)


class PinocchioSimulation:
    """See `harness.simulator.Simulation`."""

    def __init__(self, settings: Pinocchio, robot: Robot, num_envs: int, control_period: float) -> None:
        self._robot, self._w, self._frames = robot, settings.bandwidth, StillFrames(robot)
        self._substeps = Substeps(settings.substeps, control_period)
        self._model = pinocchio.buildModelFromXML(robot.urdf)
        self._data = self._model.createData()  # holds nothing from one call to the next
        self._turns_freely = np.array([joint.nq == 2 for joint in self._model.joints[1:]])
        self._touches = GroundContact(robot)
        self._qpos = np.tile(robot.home, (num_envs, 1))
        self._qvel = np.zeros_like(self._qpos)
        self._target = self._qpos.copy()  # where the ramp stands: errors do not add up over periods

    def reset(self, qpos: Float, mask: Mask) -> State:
        self._qpos[mask] = self._target[mask] = qpos[mask]
        self._qvel[mask] = 0.0
        return self.read()

    def place(self, qpos: Float) -> State:
        return self.reset(qpos, np.ones(len(qpos), bool))

    def drive(self, qpos: Float, duration: float) -> State:
        steps = self._substeps.within(duration)
        speed, period = (qpos - self._target) / duration, duration / steps
        for env in range(len(qpos)):
            for step in range(steps):
                self._step(env, self._target[env] + speed[env] * period * step, speed[env], period)
        self._target[...] = qpos
        return self.read()

    def read(self) -> State:
        tips = np.array([self._tip(qpos) for qpos in self._qpos])
        return State(self._qpos.copy(), self._qvel.copy(), tips, self._touches(self._qpos))

    def render(self, env: int, target: Float, width: int, height: int) -> NDArray[np.uint8]:
        """See `harness.simulator.Simulation`; drawn without an engine."""
        return self._frames.frame(self._qpos[env], target, width, height)

    def close(self) -> None:
        """Does nothing: Python frees what pinocchio holds."""

    def _step(self, env: int, target: Float, speed: Float, period: float) -> None:
        """One physics step of one arm, by semi-implicit Euler."""
        model, data, qpos, qvel = self._model, self._data, self._qpos[env], self._qvel[env]
        q = self._configuration(qpos)
        asked = self._w**2 * (target - qpos) + 2.0 * self._w * (speed - qvel)
        upper = np.triu(pinocchio.crba(model, data, q))  # only this half is filled
        inertia = upper + np.triu(upper, 1).T
        torque = inertia @ asked + pinocchio.computeGeneralizedGravity(model, data, q)
        qvel += period * pinocchio.aba(model, data, q, qvel, torque)
        qpos += period * qvel

    def _tip(self, qpos: Float) -> Float:
        """The end effector as pinocchio's own kinematics have it, (3,), [m]."""
        pinocchio.framesForwardKinematics(self._model, self._data, self._configuration(qpos))
        frame = self._model.getFrameId(self._robot.end_effector_link)
        return np.array(self._data.oMf[frame].translation)

    def _configuration(self, qpos: Float) -> Float:
        """Pinocchio's coordinates: a joint that turns without end is a cosine and a sine there."""
        pairs = zip(qpos, self._turns_freely, strict=True)
        return np.concatenate([[np.cos(at), np.sin(at)] if free else [at] for at, free in pairs])
