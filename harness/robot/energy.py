"""The mechanical energy of an arm's links, and the work that a motion takes at least: batched, numpy only."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from xml.etree.ElementTree import Element

import numpy as np

from harness.arrays import Float
from harness.robot.kinematics import Chain, child_frames, read_only
from harness.robot.normal_urdf import MOMENTS, NEXT_TO_NO_MASS
from harness.robot.robot import Robot
from harness.robot.shapes import moving_carrier, read_origin
from harness.robot.urdf import parse_urdf

GRAVITY = 9.81
"""[m/s^2], along -z of the world."""


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid body, or, with one more axis of length dof in front of each array, one for each joint of a chain.

    Attributes:
        mass: [kg], shape ().
        center: Its centre of mass in the frame of the child link of the joint that moves it, shape (3,), [m].
        inertia: About that point, in the same frame, shape (3, 3), [kg m^2].
    """

    mass: Float
    center: Float
    inertia: Float


def read_bodies(robot: Robot) -> Body | None:
    """What moves with each joint of a robot, all links that are fixed to one another as one body.

    Returns:
        One for each joint, arrays read-only; None where no link that moves has a mass.
    """
    return _read_bodies(robot.urdf, robot.joint_names)


@lru_cache(maxsize=8)  # of what it moves with every evaluation asks
def _read_bodies(text: str, joint_names: tuple[str, ...]) -> Body | None:
    urdf = parse_urdf(text)
    carried: dict[str, list[Body]] = {name: [] for name in joint_names}
    for name, link in urdf.links.items():
        joint, T_child_link = moving_carrier(name, urdf.carriers)
        if joint in carried:
            carried[joint].append(_read_body(link, T_child_link))
    nothing = _number(NEXT_TO_NO_MASS, "mass", "value")
    if all(body.mass <= nothing for bodies in carried.values() for body in bodies):
        return None
    joined = [_join(bodies) for bodies in carried.values()]
    return Body(*(read_only(np.array([getattr(body, name) for body in joined])) for name in vars(joined[0])))


def energy(chain: Chain, bodies: Body, qpos: Float, qvel: Float) -> Float:
    """Kinetic and potential energy of the bodies, [J]; a body at the height of the world's origin has no potential.

    Args:
        chain: Of the arm, dof joints.
        bodies: One for each joint.
        qpos: Joint positions, [rad] or [m], shape (..., dof).
        qvel: Joint speeds, [rad/s] or [m/s], shape (..., dof).

    Returns:
        Shape (...).

    Raises:
        UsageError: The last axis of qpos is not dof long.
    """
    turning = moving = before = np.zeros(3)  # of the child frame: angular velocity, velocity and place of its origin
    total: Float = np.zeros(np.shape(qpos)[:-1])
    for joint, frame in enumerate(child_frames(chain, qpos)):
        rotation, origin = frame[..., :3, :3], frame[..., :3, 3]
        moving = moving + np.cross(turning, origin - before)
        own = rotation @ chain.axes[joint] * qvel[..., joint, None]
        turning, moving = (turning, moving + own) if chain.slides[joint] else (turning + own, moving)
        lever = rotation @ bodies.center[joint]
        velocity = moving + np.cross(turning, lever)
        spin = (turning[..., None, :] @ rotation)[..., 0, :]  # in the child frame
        kinetic = bodies.mass[joint] * np.vecdot(velocity, velocity) + np.vecdot(spin @ bodies.inertia[joint], spin)
        total = total + kinetic / 2.0 + bodies.mass[joint] * GRAVITY * (origin + lever)[..., 2]
        before = origin
    return total


def least_work(chain: Chain, bodies: Body, qpos: Float, period: float) -> float:
    """The mechanical work that a motion from rest takes at least: the sum of all gains in energy, [J].

    Joint speeds are the differences of the positions over the period. Motors that take work in when the energy falls
    give nothing back, and friction is not counted.

    Args:
        chain: Of the arm, dof joints.
        bodies: One for each joint.
        qpos: Joint positions, one row per period, shape (rows, dof), [rad] or [m].
        period: From one row to the next, [s].
    """
    speeds = np.diff(qpos, axis=0, prepend=qpos[:1]) / period
    gains = np.diff(energy(chain, bodies, qpos, speeds))
    return float(gains[gains > 0.0].sum())


def _read_body(link: Element, child_link: Float) -> Body:
    """The body of a link whose frame is at T_child_link."""
    [inertial] = link.findall("inertial")  # a robot's URDF has one in each link
    T_child_body = child_link @ read_origin(inertial, f"Link '{link.get('name')}'")
    ixx, iyy, izz, ixy, ixz, iyz = (_number(inertial, "inertia", name) for name in MOMENTS)
    rotation, inertia = T_child_body[:3, :3], np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
    return Body(np.array(_number(inertial, "mass", "value")), T_child_body[:3, 3], rotation @ inertia @ rotation.T)


def _number(inertial: Element, tag: str, attribute: str) -> float:
    part = inertial.find(tag)
    return 0.0 if part is None else float(part.get(attribute, "0"))


def _join(bodies: Sequence[Body]) -> Body:
    """One body of several, which are fixed to one another."""
    mass = sum((body.mass for body in bodies), np.zeros(()))
    center = sum((body.mass * body.center for body in bodies), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for body in bodies:
        lever = body.center - center
        inertia += body.inertia + body.mass * (lever @ lever * np.eye(3) - np.outer(lever, lever))
    return Body(mass, center, inertia)
