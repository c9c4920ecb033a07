"""The equations of motion of an arm that touches nothing, by Bullet, for given joint positions and speeds."""

from pathlib import Path

import numpy as np
import pybullet

from harness import Float
from harness.robot import Robot

from .world import GRAVITY, LOAD_FLAGS, load_body, numbers

MASS, LOCAL_INERTIA, CENTRE, INERTIA_FRAME = 0, 2, 3, 4
"""The indices of these values in what ``getDynamicsInfo`` returns."""
HEAVY = 4.0
"""Bullet refuses many links with moments about their joint from 8 kg m^2 on: it takes rounding for a mistake."""


class FreeArm:
    """Computes M(q) a + h(q, v) = torque with arms that are never moved.

    All values are in SI units. M is (dof, dof), all others are (dof,).

    An armature may make a link's inertia about one axis larger than those about both other axes together. Bullet
    computes no torques for such a link. But torques are linear in the inertia. So they are twice the torques of a link
    that also has half of the armature about the other axes, less those of a link that has all of it about them.

    Torques are linear in the masses too. So a heavy arm is computed as one that is lighter by a power of two: exactly.
    """

    def __init__(self, client: int, robot: Robot, path: Path, armature: Float) -> None:
        self._client = client
        pybullet.setGravity(0.0, 0.0, GRAVITY, physicsClientId=client)
        flags = LOAD_FLAGS | pybullet.URDF_IGNORE_VISUAL_SHAPES
        self._body, self._with_half, self._with_all = (load_body(client, robot, path, flags) for _ in range(3))
        self._share = share_of(client, self._body, armature)
        if self._share < 1.0:
            for body in (self._body, self._with_half, self._with_all):
                scale_masses(client, body, self._share)
        add_armature(client, self._with_half, robot, armature * self._share, 0.5)
        add_armature(client, self._with_all, robot, armature * self._share, 1.0)
        self._still = [0.0] * robot.dof

    def gravity(self, qpos: list[float]) -> Float:
        """The torques that hold the arm's weight."""
        return self._torque(self._body, qpos, self._still, self._still)

    def bias(self, qpos: list[float], qvel: list[float]) -> Float:
        """h: the torques due to weight and speeds."""
        return self._torque(self._body, qpos, qvel, self._still)

    def inertia(self, qpos: list[float]) -> Float:
        """M, (dof, dof)."""
        return np.array(pybullet.calculateMassMatrix(self._body, qpos, physicsClientId=self._client)) / self._share

    def torque_with_armature(self, qpos: list[float], qvel: list[float], qacc: list[float]) -> Float:
        """The torques that accelerate an arm whose links have the armature."""
        state = qpos, qvel, qacc
        return 2.0 * self._torque(self._with_half, *state) - self._torque(self._with_all, *state)

    def _torque(self, body: int, qpos: list[float], qvel: list[float], qacc: list[float]) -> Float:
        torque = pybullet.calculateInverseDynamics(body, qpos, qvel, qacc, physicsClientId=self._client)
        return np.array(torque) / self._share


def share_of(client: int, body: int, armature: Float) -> float:
    """The share of all masses that Bullet computes with, a power of two; 1 where no link is heavy.

    Args:
        client: The client.
        body: The arm in it.
        armature: What the joints have beside the links, (dof,), [kg m^2] or [kg].
    """
    links = range(pybullet.getNumJoints(body, physicsClientId=client))
    given = [pybullet.getDynamicsInfo(body, link, physicsClientId=client) for link in links]
    largest = max(max(each[LOCAL_INERTIA]) + each[MASS] * np.dot(each[CENTRE], each[CENTRE]) for each in given)
    return 1.0 if largest <= HEAVY else float(2.0 ** -np.ceil(np.log2(largest + armature.max())))


def scale_masses(client: int, body: int, share: float) -> None:
    """Multiply the mass and the inertia of every link by a power of two, which rounds nothing."""
    for link in range(pybullet.getNumJoints(body, physicsClientId=client)):
        given = pybullet.getDynamicsInfo(body, link, physicsClientId=client)
        moments = [share * moment for moment in given[LOCAL_INERTIA]]  # a change of the mass changes these too
        pybullet.changeDynamics(body, link, mass=share * given[MASS], physicsClientId=client)
        pybullet.changeDynamics(body, link, localInertiaDiagonal=moments, physicsClientId=client)


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
