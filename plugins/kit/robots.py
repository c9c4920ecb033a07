"""What a robot must satisfy. Each check takes the robot, as it was read from its files."""

from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from harness import Float
from harness.env.solid_probes import require_solids
from harness.errors import MissingSolid, PluginError, UsageError
from harness.registry import choose, load_registry
from harness.robot import Robot, build_solids, read_mesh
from harness.robot.kinematics import link_frames, reach_position
from harness.robot.settings import FILE

from .contract import check, require

POSES = 20
STEP = 1e-6
"""The step of the finite differences, [rad] or [m]."""
MOST_JACOBIAN_ERROR = 1e-5
"""[m/rad] or [m/m]."""
LEAST_EFFECT = 1e-3
"""By how much a joint moves the end effector at least, in some pose, [m/rad] or [m/m]."""
MOST_MISSED = 0.1
"""Share of the arm's own places that inverse kinematics may miss, which starts at the resting pose."""
LIGHTEST = 1e-5
"""[kg]; what stands for no mass is less."""
HEAVIEST, LONGEST = 1e4, 1e2
"""[kg] of a link and [m] of a reach: more is a wrong unit."""


@check("robot-limits")
def limits_are_finite(robot: Robot) -> None:
    """Each joint has a range, a largest speed and acceleration: finite, lower end below upper, speeds positive."""
    for name in ("lower", "upper", "max_speed", "max_acceleration", "home"):
        array = getattr(robot, name)
        require(array.shape == (robot.dof,), f"{name} has shape {array.shape} for {robot.dof} joints")
        require(np.isfinite(array).all(), f"{name} is {_told(robot, array)}")
    for joint, low, high in zip(robot.joint_names, robot.lower, robot.upper, strict=True):
        require(
            low < high, f"joint '{joint}' ranges from {low:.4g} to {high:.4g}: the lower end has to be below the upper"
        )
    for name in ("max_speed", "max_acceleration"):
        require(
            (getattr(robot, name) > 0.0).all(), f"{name} is {_told(robot, getattr(robot, name))}: it has to be positive"
        )


@check("robot-home")
def home_is_in_the_joint_ranges(robot: Robot) -> None:
    """No joint of the resting pose is beyond an end of its range."""
    for joint, low, value, high in zip(robot.joint_names, robot.lower, robot.home, robot.upper, strict=True):
        require(low <= value <= high, f"joint '{joint}' rests at {value:.4g}, its range is {low:.4g} to {high:.4g}")


@check("robot-home-clear")
def home_is_above_the_ground(robot: Robot) -> None:
    """In the resting pose the end effector and every moving shape are above the ground, which would end the episode."""
    height = float(robot.end_effector(robot.home)[2])
    require(height > 0.0, f"at rest the end effector is {height:.3f} m high, the ground is z = 0: choose another home")
    frames = link_frames(robot.chain, robot.home[None])
    lowest = float(build_solids(robot.joint_shapes).lowest(frames)[0])  # infinite without a shape
    require(
        lowest > 0.0, f"at rest a moving link reaches down to {lowest:.3f} m, the ground is z = 0: choose another home"
    )


@check("robot-kinematics")
def the_jacobian_is_that_of_the_kinematics(robot: Robot) -> None:
    """The end effector moves with the joints as its Jacobian says, in any pose; and it is never beyond its reach."""
    poses = _poses(robot)
    jacobian = robot.jacobian(poses)
    for joint, name in enumerate(robot.joint_names):
        step = STEP * (np.arange(robot.dof) == joint)
        measured = (robot.end_effector(poses + step) - robot.end_effector(poses - step)) / (2.0 * STEP)
        error = float(np.abs(jacobian[..., joint] - measured).max())
        require(
            error <= MOST_JACOBIAN_ERROR, f"joint '{name}' moves the end effector differently, by {error:.2g} m/rad"
        )
    far = float(np.linalg.norm(robot.end_effector(poses), axis=-1).max())
    require(far <= robot.extent * (1.0 + 1e-9), f"the end effector is {far:.3f} m away, extent is {robot.extent:.3f} m")


@check("robot-joints-matter")
def every_joint_matters(robot: Robot) -> None:
    """Every joint but the last moves the end effector in some pose: the chain ends where the end effector is."""
    effects = np.linalg.norm(robot.jacobian(_poses(robot)), axis=-2).max(axis=0)
    for name, effect in zip(robot.joint_names[:-1], effects, strict=False):
        require(effect >= LEAST_EFFECT, f"joint '{name}' moves the end effector by {effect:.2g} m/rad at most: is it "
                f"'{robot.end_effector_link}'? Name another end_effector in {FILE}")  # fmt: skip


@check("robot-reach")
def the_arm_reaches_its_own_places(robot: Robot) -> None:
    """Inverse kinematics, which targets are drawn with, finds nearly all places where the end effector can be."""
    require(robot.reach <= LONGEST, f"the arm reaches {robot.reach:.3g} m: are its lengths in metres?")
    places = robot.end_effector(_poses(robot))
    _, reached = reach_position(robot, places, np.tile(robot.home, (len(places), 1)), iterations=200)
    missed = int((~reached).sum())
    told = f"{missed} of {len(places)} places of its own end effector are not found by inverse kinematics from its home"
    require(missed <= MOST_MISSED * len(places), told)


@check("robot-masses")
def masses_are_those_of_bodies(robot: Robot) -> None:
    """Every link has a positive mass, and a moment of inertia that a body can have: engines divide by them."""
    for link in ElementTree.fromstring(robot.urdf).findall("link"):
        inertial = link.find("inertial")
        if inertial is None:
            require(False, f"link '{link.get('name')}' has no <inertial>")
            return
        mass = _number(inertial, "mass", "value")
        require(0.0 < mass <= HEAVIEST, f"link '{link.get('name')}' has a mass of {mass:g} kg")
        xx, yy, zz, xy, xz, yz = (
            _number(inertial, "inertia", f"i{axes}") for axes in ("xx", "yy", "zz", "xy", "xz", "yz")
        )
        moments = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        require(
            moments[0] > 0.0, f"link '{link.get('name')}' has the moments of inertia {moments}: none may be 0 or less"
        )


@check("robot-meshes")
def meshes_can_be_read(robot: Robot) -> None:
    """Every mesh of the URDF is an existing file; it can be read and has points."""
    for link in ElementTree.fromstring(robot.urdf).findall("link"):
        for part in ("visual", "collision"):
            for mesh in link.iterfind(f"{part}/geometry/mesh"):
                path = Path(mesh.get("filename", ""))
                require(path.is_file(), f"link '{link.get('name')}' has the {part} mesh '{path}', which is not there")
                read_mesh(path)  # raises, and says why


@check("robot-simulators")
def simulators_have_all_solids(robot: Robot) -> None:
    """Every installed simulator loads the arm, and touches the ground with each collision shape that can touch it."""
    registry = load_registry()
    for name in registry.names("simulators"):
        if registry.get("simulators", name).missing:
            continue
        try:
            simulator = choose(registry, "simulators", name).build(registry, "simulators")
        except PluginError:
            continue  # that is no fault of the robot
        try:
            require_solids(name, simulator, robot, registry)
        except (UsageError, MissingSolid) as error:
            require(False, str(error) if name in str(error) else f"{name}: {error}")


ROBOT_CHECKS = (
    limits_are_finite,
    home_is_in_the_joint_ranges,
    home_is_above_the_ground,
    the_jacobian_is_that_of_the_kinematics,
    every_joint_matters,
    the_arm_reaches_its_own_places,
    masses_are_those_of_bodies,
    meshes_can_be_read,
)
"""What needs no simulator."""
SIMULATED_ROBOT_CHECKS = (simulators_have_all_solids,)
"""What opens every installed simulator."""


@check("robot-collision-shapes", "warning")
def moving_links_can_touch(robot: Robot) -> None:
    """At least one moving link has a collision shape: without any, no simulator sees the ground."""
    require(any(robot.joint_shapes), "no moving link has a <collision>: the ground is never touched in any simulator")


@check("robot-own-numbers", "warning")
def the_numbers_are_given(robot: Robot) -> None:
    """The author gave resting pose, speeds and accelerations: results depend on them."""
    ruled = [
        f"{name} is {origin}" for name, origin in robot.origins.items() if name != "end_effector" and origin != FILE
    ]
    require(not ruled, f"{'; '.join(ruled)}: write them in {FILE}, so that they stay when the rules change")


@check("robot-link-masses", "warning")
def links_have_masses_of_their_own(robot: Robot) -> None:
    """Every link that has a shape has a mass in the URDF. Without one, almost no mass is assumed."""
    for link in ElementTree.fromstring(robot.urdf).findall("link"):
        inertial, shaped = link.find("inertial"), link.find("collision") is not None
        mass = 0.0 if inertial is None else _number(inertial, "mass", "value")
        told = f"link '{link.get('name')}' has a shape and no mass in the URDF; {mass:g} kg is taken"
        require(not shaped or mass > LIGHTEST, told)


ROBOT_WARNINGS = (moving_links_can_touch, links_have_masses_of_their_own, the_numbers_are_given)


def _poses(robot: Robot) -> Float:
    """Joint positions at random in the middle of the ranges, (POSES, dof)."""
    rng, middle = np.random.default_rng(0), (robot.lower + robot.upper) / 2.0
    poses: Float = middle + rng.uniform(-0.4, 0.4, (POSES, robot.dof)) * (robot.upper - robot.lower)
    return poses


def _told(robot: Robot, array: Float) -> str:
    return ", ".join(f"{name} {value:.4g}" for name, value in zip(robot.joint_names, array, strict=True))


def _number(inertial: Any, tag: str, attribute: str) -> float:
    part = inertial.find(tag)
    return float(part.get(attribute, "0")) if part is not None else 0.0
