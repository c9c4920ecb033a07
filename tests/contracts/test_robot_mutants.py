"""Every robot check has a broken robot that fails it, and no other."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import harness
from harness.arrays import Float
from harness.robot import Robot, ground_clearance
from harness_plugins.kit import ROBOT_CHECKS, Check, check_robot, robots, violations
from harness_plugins.kit.simulators.simulations import way_into_the_ground

ROBOT = harness.load_robot("fd100")
CHAIN = ROBOT.chain


def at(index: int, value: float, array: Float) -> Float:
    """The array with another number at one place."""
    changed = array.copy()
    changed[index] = value
    return changed


def urdf(old: str, new: str) -> Robot:
    """The FD100 with another text in its URDF, at its first place."""
    assert old in ROBOT.urdf
    return replace(ROBOT, urdf=ROBOT.urdf.replace(old, new, 1))


def with_mesh(part: str, path: str) -> Robot:
    """The FD100 with a mesh as a visual or a collision shape of its second link."""
    mesh = f'<{part}><geometry><mesh filename="{path}"/></geometry></{part}>'
    start = ROBOT.urdf.index("<link", ROBOT.urdf.index("<link") + 1)
    end = ROBOT.urdf.index(">", start) + 1
    return replace(ROBOT, urdf=ROBOT.urdf[:end] + mesh + ROBOT.urdf[end:])


class TurnsTheOtherWay(Robot):
    """The Jacobian has the sign of a joint wrong."""

    def jacobian(self, qpos: Float) -> Float:
        """Of another arm."""
        return super().jacobian(qpos) * np.where(np.arange(self.dof) == 1, -1.0, 1.0)


class OtherTip(Robot):
    """The end effector is another point of the last link; the Jacobian is not."""

    def end_effector(self, qpos: Float) -> Float:
        """Of the next joint's angle."""
        return super().end_effector(np.asarray(qpos) * 1.001)


def as_a(kind: type[Robot]) -> Robot:
    """The FD100, of a class that computes otherwise."""
    return kind(**{name: getattr(ROBOT, name) for name in ROBOT.__dataclass_fields__})


def floating_last_joints() -> Robot:
    """The end effector is the second joint's link: what comes after it moves nothing."""
    axes = CHAIN.axes.copy()
    still = replace(ROBOT, chain=CHAIN)
    axes[3] = 0.0
    return replace(still, chain=type(CHAIN)(CHAIN.T_previous_joint, axes, CHAIN.kinds, CHAIN.T_last_tip))


def in_millimetres() -> Robot:
    """A thousand times as large."""
    joints, tip = CHAIN.T_previous_joint.copy(), CHAIN.T_last_tip.copy()
    joints[:, :3, 3] *= 1e3
    tip[:3, 3] *= 1e3
    return replace(ROBOT, chain=type(CHAIN)(joints, CHAIN.axes, CHAIN.kinds, tip), joint_shapes=((),) * ROBOT.dof)


MUTANTS: dict[str, tuple[Callable[[], Robot], Check]] = {
    "no range": (lambda: replace(ROBOT, max_speed=at(0, 0.0, ROBOT.max_speed)), robots.limits_are_finite),
    "no acceleration": (
        lambda: replace(ROBOT, max_acceleration=at(5, -1.0, ROBOT.max_acceleration)), robots.limits_are_finite,
    ),
    "rests beyond": (lambda: replace(ROBOT, home=at(5, 10.0, ROBOT.home)), robots.home_is_in_the_joint_ranges),
    "rests in the ground": (
        lambda: replace(ROBOT, home=way_into_the_ground(ROBOT)[-1]), robots.home_is_above_the_ground,
    ),
    "another tip": (lambda: as_a(OtherTip), robots.the_jacobian_is_that_of_the_kinematics),
    "weightless link": (lambda: urdf('mass value="', 'mass value="-'), robots.masses_are_those_of_bodies),
    "mass in grams": (lambda: urdf('mass value="', 'mass value="99999'), robots.masses_are_those_of_bodies),
    "no inertia": (lambda: urdf('ixx="', 'ixx="-'), robots.masses_are_those_of_bodies),
    "mesh is gone": (lambda: with_mesh("visual", "/nowhere/link.stl"), robots.meshes_can_be_read),
}  # fmt: skip
COARSE_MUTANTS: dict[str, tuple[Callable[[], Robot], Check]] = {
    "joint without axis": (floating_last_joints, robots.every_joint_matters),
    "endless range": (lambda: replace(ROBOT, upper=at(2, np.inf, ROBOT.upper)), robots.limits_are_finite),
    "wrong Jacobian": (lambda: as_a(TurnsTheOtherWay), robots.the_jacobian_is_that_of_the_kinematics),
    "in millimetres": (in_millimetres, robots.the_arm_reaches_its_own_places),
    "turned limits": (
        lambda: replace(ROBOT, lower=ROBOT.upper, upper=ROBOT.lower), robots.limits_are_finite,
    ),
}  # fmt: skip


def failing(robot: Robot) -> list[str]:
    """Names of the checks that a robot fails."""
    return [violation.check for violation in violations(ROBOT_CHECKS, robot)]


def test_mutant_fails_one_check(subtests: pytest.Subtests):
    """A robot that is broken in one way fails the check of that fact, and no other."""
    for name, (make, check) in MUTANTS.items():
        with subtests.test(name=name):
            assert failing(make()) == [check.name]


@pytest.mark.parametrize("name", COARSE_MUTANTS)
def test_coarse_mutant_fails_its_check(name: str):
    """A robot that is broken in a way that shows in several places fails, among others, the check nearest to it."""
    make, check = COARSE_MUTANTS[name]
    assert check.name in failing(make())


@pytest.mark.parametrize("content", [b"", b"solid nothing\nendsolid nothing\n"])
def test_mesh_without_points_is_found(tmp_path: Path, content: bytes):
    """A file that is there and holds nothing."""
    path = tmp_path / "link.stl"
    path.write_bytes(content)
    assert failing(with_mesh("collision", str(path))) == ["robot-meshes"]


def test_every_check_has_a_mutant():
    """No check is without a robot that fails it."""
    assert {check for _, check in [*MUTANTS.values(), *COARSE_MUTANTS.values()]} == set(ROBOT_CHECKS)


def test_an_arm_that_a_simulator_drops_a_solid_of_is_found(monkeypatch: pytest.MonkeyPatch):
    """With the simulator's name and the link's, as ``harness check --robot`` says it."""
    build = ground_clearance.build_solids
    monkeypatch.setattr("harness_plugins.simulators.kinematic.build_solids", lambda shapes: build(shapes[:-1]))
    (violation,) = violations(robots.SIMULATED_ROBOT_CHECKS, ROBOT)
    assert violation.check == "robot-simulators"
    assert "Simulator 'kinematic' has no solid for link 'tool0'" in violation.sentence


def test_own_robots_are_loaded_by_every_simulator():
    """That is installed."""
    assert list(violations(robots.SIMULATED_ROBOT_CHECKS, ROBOT)) == []


@pytest.mark.parametrize("name", ["fd100", "unity-arm"])
def test_own_robots_keep_the_contract(name: str):
    """Without a word, warnings included."""
    robot = harness.load_robot(name)
    assert check_robot(robot) is None
    assert list(violations(robots.ROBOT_WARNINGS, robot)) == []


WARNED = {
    "robot-collision-shapes": lambda: replace(ROBOT, joint_shapes=((),) * ROBOT.dof),
    "robot-link-masses": lambda: urdf('mass value="', 'mass value="1e-7" was="'),
    "robot-own-numbers": lambda: replace(ROBOT, origins={**ROBOT.origins, "home": "the simplest pose"}),
}


@pytest.mark.parametrize("name", WARNED)
def test_what_may_be_meant_is_warned_of(name: str):
    """The contract is kept, and one check says what to look at."""
    (violation,) = violations(robots.ROBOT_WARNINGS, WARNED[name]())
    assert (violation.check, violation.level) == (name, "warning")
