"""Arms to move, and how a motion's moves are followed."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from numpy.linalg import norm
from numpy.random import default_rng

from harness.robot import Robot
from harness.robot.kinematics import build_chain
from harness.robot.urdf import Joint
from harness.task import Setting
from tests.registered import FD100, UNITY_ARM

PERIOD = 0.1
SPEED, ACCELERATION = 0.8, 0.6
"""NOTE Table I."""


class Course(NamedTuple):
    """What `count` control periods of a motion came to, in `parts` waypoints each."""

    qpos: np.ndarray
    """Joint targets, (count * parts + 1, n, dof)."""
    held: np.ndarray
    """(count, n)."""
    qvel: np.ndarray
    """Speeds that the motion tells, (count, n, dof)."""


def follow(motion, qpos, actions):
    """The course of `actions`, each (n, action_size), from rest at `qpos`, (n, dof)."""
    positions, held, speeds, qvel = [qpos], [], [], np.zeros_like(qpos)
    for action in actions:
        move = motion.advance(qpos, qvel, action)
        qpos, qvel = move.waypoints[-1], move.qvel
        positions += move.waypoints
        held.append(np.zeros(len(qpos), bool) if move.held is None else move.held)
        speeds.append(qvel)
    return Course(np.array(positions), np.array(held), np.array(speeds))


def assert_within_limits(course, limits):
    """Numbers only, in the ranges, at allowed speeds that change as they may; `limits` of one part."""
    assert np.isfinite(course.qpos).all()
    assert (course.qpos >= limits.lower).all()
    assert (course.qpos <= limits.upper).all()
    speeds = np.diff(course.qpos, axis=0, prepend=course.qpos[:1]) / limits.period
    assert (np.abs(speeds) <= limits.max_speed + 1e-9).all()
    assert (np.abs(np.diff(speeds, axis=0)) <= limits.max_change + 1e-9).all()


def build_arm(name, joints):
    """An arm of joints (kind, axis, xyz), the last one 0.3 m before the end effector, home in the middle."""
    chain = [Joint(f"j{k}", kind, f"l{k}", f"l{k + 1}", xyz, (0, 0, 0), axis, -1, 1, None) for k, (kind, axis, xyz) in
             enumerate(joints)]  # fmt: skip
    tip = Joint("tip", "fixed", f"l{len(joints)}", "tip", (0.3, 0.0, 0.0), (0, 0, 0), (1, 0, 0), -np.inf, np.inf, None)
    half = np.array([0.4 if kind == "prismatic" else 2.0 for kind, _, _ in joints])
    return Robot(
        name=name,
        urdf="",
        folder=Path(),
        end_effector_link="tip",
        joint_names=tuple(joint.name for joint in chain),
        lower=-half,
        upper=half,
        max_speed=np.full(len(joints), 1.5),
        max_acceleration=np.full(len(joints), 8.0),
        home=0.25 * half,
        chain=build_chain([*chain, tip]),
        link_shapes={},
        joint_shapes=((),) * len(joints),
        origins={},
    )


X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def gantry():
    """Three slides, one along each axis."""
    return build_arm("gantry", [("prismatic", axis, (0.0, 0.0, 0.2)) for axis in (X, Y, Z)])


def scara():
    """Two turns about z and a slide along it."""
    turn = ("revolute", Z, (0.4, 0.0, 0.0))
    return build_arm("scara", [turn, turn, ("prismatic", Z, (0.4, 0.0, 0.5))])


def elbow():
    """A turn about z and two about y: the fewest joints that move in space."""
    return build_arm("elbow", [("revolute", Z, (0.0, 0.0, 0.3)), *[("revolute", Y, (0.4, 0.0, 0.0))] * 2])


MAKERS = {
    "fd100": lambda: FD100,
    "unity-arm": lambda: UNITY_ARM,
    "gantry": gantry,
    "scara": scara,
    "elbow": elbow,
}


@pytest.fixture(scope="session", params=MAKERS)
def arm(request):
    """Each of the arms."""
    return MAKERS[request.param]()


@pytest.fixture(scope="session")
def arm_of():
    """See `build_arm`."""
    return build_arm


@pytest.fixture(scope="session")
def fd100():
    """The arm that this project is about."""
    return FD100


@pytest.fixture(scope="session")
def setting_of():
    """The NOTE's setting for an arm."""
    return lambda robot: Setting(robot, PERIOD, SPEED, ACCELERATION)


@pytest.fixture(scope="session")
def course_of():
    """See `follow`."""
    return follow


@pytest.fixture(scope="session")
def require_limits():
    """See `assert_within_limits`."""
    return assert_within_limits


@pytest.fixture(scope="session")
def poses():
    """Random poses, (count, dof), in the share `spread` of the ranges around their middle."""

    def draw(robot, count, spread=1.0, seed=0):
        share = default_rng(seed).uniform(-spread, spread, (count, robot.dof))
        return (robot.upper + robot.lower) / 2.0 + share * (robot.upper - robot.lower) / 2.0

    return draw


@pytest.fixture(scope="session")
def directions():
    """Random unit vectors, (count, 3)."""

    def draw(count, seed=0):
        vectors = default_rng(seed).normal(size=(count, 3))
        return vectors / norm(vectors, axis=1, keepdims=True)

    return draw
