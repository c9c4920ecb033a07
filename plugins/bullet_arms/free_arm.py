"""The equations of motion of an arm that touches nothing, by Bullet; of joint positions and speeds that are given."""

import numpy as np
import pybullet

from harness.arrays import Float
from harness.robot import Robot

from .world import GRAVITY, LOAD_FLAGS, load_body, numbers

LOCAL_INERTIA, INERTIA_FRAME = 2, 4
"""Their places in what Bullet tells of a link."""


class FreeArm:
    """Arms that are never moved: M(q) a + h(q, v) = torque, in SI units, all of shape (dof,) but M.

    Bullet computes no torques of a link that turns about one axis harder than about both others together, as one with
    an armature does. They are linear in the inertia: twice those of a link with half of the armature about the other
    axes, less those of one with all of it.
    """

    def __init__(self, client: int, robot: Robot, armature: Float) -> None:
        self._client = client
        pybullet.setGravity(0.0, 0.0, GRAVITY, physicsClientId=client)
        flags = LOAD_FLAGS | pybullet.URDF_IGNORE_VISUAL_SHAPES
        self._body, self._with_half, self._with_all = (load_body(client, robot, flags) for _ in range(3))
        add_armature(client, self._with_half, robot, armature, 0.5)
        add_armature(client, self._with_all, robot, armature, 1.0)
        self._still = [0.0] * robot.dof

    def gravity(self, qpos: list[float]) -> Float:
        """The torques that hold the arm's weight."""
        return self._torque(self._body, qpos, self._still, self._still)

    def bias(self, qpos: list[float], qvel: list[float]) -> Float:
        """h: the torques of weight and of speeds."""
        return self._torque(self._body, qpos, qvel, self._still)

    def inertia(self, qpos: list[float]) -> Float:
        """M, (dof, dof)."""
        return np.array(pybullet.calculateMassMatrix(self._body, qpos, physicsClientId=self._client))

    def torque_with_armature(self, qpos: list[float], qvel: list[float], qacc: list[float]) -> Float:
        """What accelerates an arm to whose links `add_armature` was done."""
        state = qpos, qvel, qacc
        return 2.0 * self._torque(self._with_half, *state) - self._torque(self._with_all, *state)

    def _torque(self, body: int, qpos: list[float], qvel: list[float], qacc: list[float]) -> Float:
        return np.array(pybullet.calculateInverseDynamics(body, qpos, qvel, qacc, physicsClientId=self._client))


def add_armature(client: int, body: int, robot: Robot, armature: Float, about_others: float = 0.0) -> None:
    """Give each link that turns the armature of its joint as inertia about the joint's axis, before anything moves.

    Bullet keeps the moments about the link's principal axes alone.

    Args:
        client: Of the body.
        body: The arm.
        robot: The same.
        armature: Of the joints, (dof,), [kg m^2].
        about_others: Share of it that is added about the axes across, 0 to 1.
    """
    _, joints = numbers(client, body, robot)
    for joint, axis, slides, added in zip(joints, robot.chain.axes, robot.chain.slides, armature, strict=True):
        link = pybullet.getDynamicsInfo(body, joint, physicsClientId=client)
        rotation = np.reshape(pybullet.getMatrixFromQuaternion(link[INERTIA_FRAME]), (3, 3))
        along = (axis @ rotation) ** 2
        moments = link[LOCAL_INERTIA] + (not slides) * added * (along + about_others * (1.0 - along))
        pybullet.changeDynamics(body, joint, localInertiaDiagonal=moments.tolist(), physicsClientId=client)
