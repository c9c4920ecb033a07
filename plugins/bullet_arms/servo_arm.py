"""One arm whose joints are moved by the drives of its robot.toml."""

from pathlib import Path

import numpy as np
import pybullet

from harness import Float
from harness.robot import Robot, Servo
from harness.simulator import Substeps

from ..arms.dry_friction import DryFriction
from .arm import Arm
from .free_arm import FreeArm, add_armature
from .world import set_steps


class ServoArm(Arm):
    """An arm in the world of one client that is driven by torques.

    An arm that touches nothing moves by (M + armature) a + h = torque - friction, where the frictions are those at the
    end of the step. Bullet knows neither armature nor such a friction. So it gets the torques that give its links the
    accelerations a.

    A link that touches something should resist with its armature too. So each link has the armature of its joint as
    inertia about the joint's axis. This is not exact: the links before it carry that inertia too, and a sliding link
    has none. That makes a difference only for these links, and only while the arm touches something.
    """

    def __init__(
        self, client: int, robot: Robot, path: Path, servo: Servo, free: FreeArm,
        substeps: Substeps, iterations: int, self_collision: bool,
    ) -> None:  # fmt: skip
        super().__init__(client, robot, path, substeps, iterations, self_collision)
        self._servo, self._free = servo, free
        self._friction = DryFriction(servo.dry_friction * self._timestep)
        set_steps(client, self._timestep, 1)
        nothing = [0.0] * robot.dof
        pybullet.setJointMotorControlArray(
            self.body, self.joints, pybullet.VELOCITY_CONTROL,
            targetVelocities=nothing, forces=nothing, physicsClientId=client,
        )  # fmt: skip
        add_armature(client, self.body, robot, servo.armature)

    def put(self, qpos: Float) -> None:
        super().put(qpos)
        self._friction.forget()

    def follow(self, qpos_ref: Float, qvel_ref: Float) -> None:
        body, joints, client = self.body, self.joints, self.client
        for position, speed in zip(qpos_ref, qvel_ref, strict=True):
            states = pybullet.getJointStates(body, joints, physicsClientId=client)
            qpos, qvel = [state[0] for state in states], [state[1] for state in states]
            torque = self._torque(qpos, qvel, position, speed)
            pybullet.setJointMotorControlArray(
                body, joints, pybullet.TORQUE_CONTROL, forces=torque.tolist(), physicsClientId=client
            )
            pybullet.stepSimulation(physicsClientId=client)
        self._has_moved = True

    def _torque(self, qpos: list[float], qvel: list[float], qpos_ref: Float, qvel_ref: Float) -> Float:
        """The torques that accelerate Bullet's links as the drives accelerate the arm, (dof,), [N m] or [N]."""
        servo, free, timestep = self._servo, self._free, self._timestep
        gravity = free.gravity(qpos) if servo.gravity_compensated else 0.0
        driven = servo.torque(qpos, qvel, qpos_ref, qvel_ref, gravity)
        # The mobility turns an impulse into a change of speed. Viscous friction is that at the end of the step.
        inertia = free.inertia(qpos) + np.diag(servo.armature + timestep * servo.viscous_friction)
        mobility = np.linalg.inv(inertia).astype(np.float64, copy=False)
        load = driven - servo.viscous_friction * qvel - free.bias(qpos, qvel)
        slowed = self._friction.slow(qvel + timestep * (mobility @ load), mobility)
        return free.torque_with_armature(qpos, qvel, ((slowed - qvel) / timestep).tolist())
