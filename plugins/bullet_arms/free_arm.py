"""The equations of motion of an arm that touches nothing, by Bullet, for given joint positions and speeds."""

from pathlib import Path

import numpy as np
import pybullet

from harness.arrays import Float
from harness.robot import Robot

from .world import GRAVITY, LOAD_FLAGS, load_body, numbers

LOCAL_INERTIA, INERTIA_FRAME = 2, 4
"""The indices of these two values in what ``getDynamicsInfo`` returns."""


class FreeArm:
    """Computes M(q) a + h(q, v) = torque with arms that are never moved.

    All values are in SI units. M is (dof, dof), all others are (dof,).

    An armature may make a link's inertia about one axis larger than those about both other axes together. Bullet
    computes no torques for such a link. But torques are linear in the inertia. So they are twice the torques of a link
    that also has half of the armature about the other axes, less those of a link that has all of it about them.
    """

    def __init__(self, client: int, robot: Robot, path: Path, armature: Float) -> None:
        self._client = client
        pybullet.setGravity(0.0, 0.0, GRAVITY, physicsClientId=client)
        flags = LOAD_FLAGS | pybullet.URDF_IGNORE_VISUAL_SHAPES
        self._body, self._with_half, self._with_all = (load_body(client, robot, path, flags) for _ in range(3))
        add_armature(client, self._with_half, robot, armature, 0.5)
        add_armature(client, self._with_all, robot, armature, 1.0)
        self._still = [0.0] * robot.dof

    def gravity(self, qpos: list[float]) -> Float:
        """The torques that hold the arm's weight."""
        return self._torque(self._body, qpos, self._still, self._still)

    def bias(self, qpos: list[float], qvel: list[float]) -> Float:
        """h: the torques due to weight and speeds."""
        return self._torque(self._body, qpos, qvel, self._still)

    def inertia(self, qpos: list[float]) -> Float:
        """M, (dof, dof)."""
        return np.array(pybullet.calculateMassMatrix(self._body, qpos, physicsClientId=self._client))

    def torque_with_armature(self, qpos: list[float], qvel: list[float], qacc: list[float]) -> Float:
        """The torques that accelerate an arm whose links have the armature."""
        state = qpos, qvel, qacc
        return 2.0 * self._torque(self._with_half, *state) - self._torque(self._with_all, *state)

    def _torque(self, body: int, qpos: list[float], qvel: list[float], qacc: list[float]) -> Float:
        return np.array(pybullet.calculateInverseDynamics(body, qpos, qvel, qacc, physicsClientId=self._client))


def add_armature(client: int, body: int, robot: Robot, armature: Float, about_others: float = 0.0) -> None:
    """Add the armature of each turning joint to the inertia of its link about the joint's axis.

    Call it before anything moves. Bullet keeps only the moments about the link's principal axes.

    Args:
        client: The client of the body.
        body: Bullet's number of the arm.
        robot: The arm.
        armature: Armature of the joints, (dof,), [kg m^2].
        about_others: Share of the armature that is also added about the other axes, 0 to 1.
    """
    _, joints = numbers(client, body, robot)
    for joint, axis, slides, added in zip(joints, robot.chain.axes, robot.chain.slides, armature, strict=True):
        link = pybullet.getDynamicsInfo(body, joint, physicsClientId=client)
        rotation = np.reshape(pybullet.getMatrixFromQuaternion(link[INERTIA_FRAME]), (3, 3))
        along = (axis @ rotation) ** 2
        moments = link[LOCAL_INERTIA] + (not slides) * added * (along + about_others * (1.0 - along))
        pybullet.changeDynamics(body, joint, localInertiaDiagonal=moments.tolist(), physicsClientId=client)
