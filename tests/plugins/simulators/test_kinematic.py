"""The kinematic simulator: exact joints, and the ground contact that MuJoCo sees."""

import re
import shutil
import sys
from dataclasses import replace
from xml.parsers import expat

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import harness
from harness_plugins.simulators.kinematic import Kinematic
from tests.plugins.simulators.conftest import PERIOD, ROBOT, bare_model, lowest_height, random_poses
from tests.refusals import refused

NEAR = 2e-3
"""Nearer to touching than this the engines may differ [m]."""


@pytest.fixture
def read_changed(tmp_path):
    """Read the FD100 with another text for its URDF."""

    def read(urdf):
        shutil.copytree(ROBOT.folder, tmp_path / "arm")
        (tmp_path / "arm" / "fd100.urdf").write_text(urdf)
        return harness.load_robot(tmp_path / "arm")

    return read


def with_cylinders_as(kind):
    """The FD100's URDF, its cylinders replaced by capsules or spheres of the same radius."""
    cylinder = r'<cylinder radius="([^"]*)" length="([^"]*)"/>'
    shape = {"cylinder": r"\g<0>", "capsule": r'<capsule radius="\1" length="\2"/>', "sphere": r'<sphere radius="\1"/>'}
    return re.sub(cylinder, shape[kind], ROBOT.urdf)


@pytest.mark.parametrize("kind", ["cylinder", "capsule", "sphere"])
def test_ground_contact_is_that_of_mujoco(read_changed, kind, open_arms):
    """On 4,000 random poses the arm touches the ground where it does in MuJoCo, but for 2 mm around touching."""
    robot, poses = read_changed(with_cylinders_as(kind)), random_poses(4000)
    contact = open_arms(4000, robot).place(poses).ground_contact
    model = bare_model(robot)
    heights = np.array([lowest_height(pose, model) for pose in poses])
    clear = np.abs(heights) > NEAR
    assert_array_equal(contact[clear], heights[clear] < 0.0)
    assert 1000 < contact.sum() < 3000
    assert (~clear).sum() < 100  # nearly all poses are compared


def test_urdf_is_parsed_once(read_changed, monkeypatch, open_arms):
    """From a file to an arm that moves, joints to be fixed and links without mass included."""
    finger = '<link name="finger"/><joint name="grip" type="prismatic"><parent link="tool0"/><child link="finger"/>'
    finger += '<limit lower="0" upper="0.1"/></joint>'
    parsers, make = [], expat.ParserCreate
    monkeypatch.setattr(expat, "ParserCreate", lambda *given: parsers.append(1) or make(*given))
    robot = read_changed(ROBOT.urdf.replace("</robot>", f"{finger}</robot>"))
    assert 'name="grip" type="fixed"' in robot.urdf
    open_arms(2, robot).drive(random_poses(2), PERIOD)
    assert parsers == [1]


def test_joints_are_exactly_where_they_are_driven(open_arms):
    """After `drive` the joints are at the target, bit for bit, and their speed is the way over the time."""
    simulation, first, second = open_arms(50), random_poses(50), random_poses(100)[50:]
    simulation.drive(first, PERIOD)
    state = simulation.drive(second, 0.25)
    assert_array_equal(state.qpos, second)
    assert_array_equal(state.qvel, (second - first) / 0.25)


def test_arms_are_at_rest_where_they_are_reset(open_arms):
    """`reset` ends the motion of the arms in its mask, and of no other."""
    simulation, mask = open_arms(6), np.arange(6) < 2
    poses = random_poses(6)
    simulation.drive(poses, PERIOD)
    state = simulation.reset(poses[::-1], mask)
    assert_array_equal(state.qpos, np.where(mask[:, None], poses[::-1], poses))
    assert_array_equal(state.qvel, np.where(mask[:, None], 0.0, (poses - ROBOT.home) / PERIOD))


def test_arms_that_are_placed_where_they_stand_are_not_computed_again(monkeypatch, open_arms):
    """A decision that lasts repeats its pose: the state is the same, and the arms are at rest."""
    arms, poses = open_arms(3), random_poses(3)
    arms.drive(poses, PERIOD)
    asked = []
    monkeypatch.setattr(arms, "_place_links", lambda qpos: asked.append(1))
    state = arms.place(poses.copy())
    assert not asked
    assert (state.qvel == 0.0).all()
    for mine, other in zip(state, open_arms(3).place(poses), strict=True):
        assert_array_equal(mine, other)


def test_end_effector_is_that_of_the_robot(open_arms):
    """Anywhere in the joint ranges, to rounding."""
    poses = random_poses(1000)
    assert_allclose(open_arms(1000).drive(poses, PERIOD).end_effector, ROBOT.end_effector(poses), atol=1e-14)


@pytest.mark.parametrize("begin", [ROBOT.home, np.zeros(ROBOT.dof)])
def test_arms_start_at_home_and_at_rest(begin):
    """A simulation that was just opened has its arms at home, off the ground, also where home is zero."""
    state = Kinematic().open(replace(ROBOT, home=begin), 3, PERIOD).read()
    assert_array_equal(state.qpos, np.tile(begin, (3, 1)))
    assert_array_equal(state.qvel, 0.0)
    assert_allclose(state.end_effector, np.tile(ROBOT.end_effector(begin), (3, 1)), atol=1e-14)
    assert not state.ground_contact.any()


def test_state_does_not_depend_on_the_batch(open_arms):
    """An arm alone tells, bit for bit, what it tells among 500: driven, and reset beside arms that go on."""
    poses = random_poses(500)
    batch = open_arms(500)
    driven = [np.array(array) for array in batch.drive(poses, PERIOD)]
    mask = np.arange(500) % 3 == 0
    reset = [np.array(array) for array in batch.reset(poses[::-1], mask)]
    for env in range(0, 500, 7):
        alone = open_arms(1)
        for one, many in zip(alone.drive(poses[env][None], PERIOD), driven, strict=True):
            assert_array_equal(one[0], many[env])
        for one, many in zip(alone.reset(poses[::-1][env][None], mask[env][None]), reset, strict=True):
            assert_array_equal(one[0], many[env])


def test_rendering_without_pillow_says_what_to_install(open_arms, monkeypatch):
    """`render` draws without an engine, but not without a library."""
    monkeypatch.setitem(sys.modules, "PIL", None)
    with refused(r"fd100-harness\[video\]"):
        open_arms(1).render(0, np.zeros(3), 64, 48)
