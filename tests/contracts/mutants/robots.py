"""Broken robots: the FD100 with something changed."""

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from harness.robot import Robot
from harness_plugins.kit.simulators.simulations import way_into_the_ground
from tests.registered import FD100 as ROBOT

CHAIN = ROBOT.chain
KEPT = tempfile.TemporaryDirectory()
"""Of meshes."""


def at(name, index, value):
    """With another number at one place."""
    changed = getattr(ROBOT, name).copy()
    changed[index] = value
    return replace(ROBOT, **{name: changed})


def urdf(old, new):
    """With another text in its URDF, at its first place."""
    assert old in ROBOT.urdf
    return replace(ROBOT, urdf=ROBOT.urdf.replace(old, new, 1))


def with_mesh(part, path):
    """With a mesh as a visual or a collision shape of its second link."""
    mesh = f'<{part}><geometry><mesh filename="{path}"/></geometry></{part}>'
    end = ROBOT.urdf.index(">", ROBOT.urdf.index("<link", ROBOT.urdf.index("<link") + 1)) + 1
    return replace(ROBOT, urdf=ROBOT.urdf[:end] + mesh + ROBOT.urdf[end:])


def with_content(name, content):
    """With a collision mesh that is there and holds nothing."""
    path = Path(KEPT.name) / name
    path.write_bytes(content)
    return with_mesh("collision", path)


def computing(**changed):
    """Of a class that computes otherwise."""
    fields = {name: getattr(ROBOT, name) for name in ROBOT.__dataclass_fields__}
    return type("Mutant", (Robot,), changed)(**fields)


def chain(joints=CHAIN.T_previous_joint, axes=CHAIN.axes, tip=CHAIN.T_last_tip, **changed):
    """With another chain."""
    return replace(ROBOT, chain=type(CHAIN)(joints, axes, CHAIN.kinds, tip), **changed)


MILLIMETRES = np.array([[1.0, 1.0, 1.0, 1e3]] * 3 + [[1.0] * 4])
NO_SHAPES = ((),) * ROBOT.dof
SOUND = ()
"""Every registered robot is checked as it is."""
MUTANTS = {
    "no range": ("robot-limits", at("max_speed", 0, 0.0), "max_speed"),
    "no acceleration": ("robot-limits", at("max_acceleration", 5, -1.0), "max_acceleration"),
    "endless range": ("robot-limits", at("upper", 2, np.inf), "upper is"),
    "turned limits": (
        "robot-limits",
        replace(ROBOT, lower=ROBOT.upper, upper=ROBOT.lower),
        "has to be below the upper",
    ),
    "rests beyond": ("robot-home", at("home", 5, 10.0)),
    "rests in the ground": ("robot-home-clear", replace(ROBOT, home=way_into_the_ground(ROBOT)[-1])),
    "another tip": (
        "robot-kinematics",
        computing(end_effector=lambda self, qpos: Robot.end_effector(self, np.asarray(qpos) * 1.001)),
    ),
    "wrong Jacobian": (
        "robot-kinematics",
        computing(
            jacobian=lambda self, qpos: Robot.jacobian(self, qpos) * np.where(np.arange(self.dof) == 1, -1.0, 1.0)
        ),
    ),
    "joint without axis": (
        "robot-joints-matter",
        chain(axes=CHAIN.axes * (np.arange(ROBOT.dof) != 3)[:, None]),
        "joint 'joint4' moves",
    ),
    "in millimetres": (
        "robot-reach",
        chain(CHAIN.T_previous_joint * MILLIMETRES, tip=CHAIN.T_last_tip * MILLIMETRES, joint_shapes=NO_SHAPES),
        "the arm reaches 1.54e+03 m: are its lengths in metres?",
    ),
    "weightless link": ("robot-masses", urdf('mass value="', 'mass value="-'), "a mass of -46 kg"),
    "mass in grams": ("robot-masses", urdf('mass value="', 'mass value="99999'), "a mass of 9.99995e+06 kg"),
    "no inertia": ("robot-masses", urdf('ixx="', 'ixx="-'), "the moments of inertia"),
    "mesh is gone": ("robot-meshes", with_mesh("visual", "/nowhere/link.stl"), "which is not there"),
    "empty mesh": ("robot-meshes", with_content("empty.stl", b""), "raised UsageError: "),
    "mesh without points": (
        "robot-meshes",
        with_content("points.stl", b"solid nothing\nendsolid nothing\n"),
        "it holds no points",
    ),
    "no shapes": ("robot-collision-shapes", replace(ROBOT, joint_shapes=NO_SHAPES)),
    "mass of next to nothing": ("robot-link-masses", urdf('mass value="', 'mass value="1e-7" was="')),
    "pose that nobody gave": (
        "robot-own-numbers",
        replace(ROBOT, origins={**ROBOT.origins, "home": "the simplest pose"}),
    ),
}
