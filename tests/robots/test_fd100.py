"""The FD100: its published ranges, its nominal lengths, and how it stands on the ground."""

import math
import re
from itertools import pairwise
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.linalg import norm
from numpy.random import default_rng
from numpy.testing import assert_allclose

import harness_robots
from harness.robot.robot import read_robot

ROBOT = read_robot(harness_robots.FD100)
LINKS = ElementTree.fromstring(ROBOT.urdf).findall("link")
MOVING = ("link1", "link2", "link3", "link4", "link5", "link6", "tool0")

POSES = st.tuples(*(st.floats(low, high) for low, high in zip(ROBOT.lower, ROBOT.upper, strict=True))).map(np.array)


@pytest.fixture(scope="module")
def model():
    """The arm on a ground plane, every link a body of its own."""
    spec = mujoco.MjSpec.from_string(ROBOT.urdf)
    spec.compiler.fusestatic = False
    spec.worldbody.add_geom(name="ground", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[3.0, 3.0, 0.1])
    return spec.compile()


def _random_poses(count):
    return default_rng(100).uniform(ROBOT.lower, ROBOT.upper, (count, ROBOT.dof))


def _height_above_ground(model, data, qpos):
    """Smallest distance of a moving link's shape from the ground [m], negative inside it."""
    data.qpos[:] = qpos
    mujoco.mj_forward(model, data)
    moving = [geom for geom in range(model.ngeom) if model.body(model.geom_bodyid[geom]).name in MOVING]
    ground = model.geom("ground").id
    return min(mujoco.mj_geomDistance(model, data, ground, geom, 3.0, None) for geom in moving)


def test_pose_computed_by_hand(subtests):
    """The flange is where the nominal lengths put it."""
    rows = [
        # d1 + a2 + a3 = 1.16 up, a1 + d4 + d6 = 0.92 forward
        ([0, 0, 0, 0, 0, 0], (0.92, 0.0, 1.16)),
        ([90, 0, 0, 0, 0, 0], (0.0, 0.92, 1.16)),
        # the upper arm forward, the forearm down: x = a1 + a2 + a3, z = d1 - d4 - d6
        ([0, 90, 0, 0, 0, 0], (0.91, 0.0, -0.31)),
        # the flange down: x = a1 + d4, z = d1 + a2 + a3 - d6
        ([0, 0, 0, 0, 90, 0], (0.81, 0.0, 1.05)),
        # the bent wrist turned to the side: the flange along +y after -90 degrees of J4 about x
        ([0, 0, 0, -90, -90, 0], (0.81, 0.11, 1.16)),
        # the forearm up, by 90 degrees from the upper arm leant forward: x = a1 + a2 + d4 + d6, z = d1 + a3
        ([0, 90, -90, 0, 0, 0], (1.53, 0.0, 0.55)),
        ([0, 0, 0, 40, 0, 300], (0.92, 0.0, 1.16)),
    ]
    for qpos_deg, position in rows:
        with subtests.test(qpos_deg=qpos_deg):
            assert_allclose(ROBOT.end_effector(np.radians(qpos_deg)), position, atol=1e-12)


def test_tool_points_along_the_forearm(model, data):
    """At the zero pose the tool's z axis is the world's +x."""
    mujoco.mj_kinematics(model, data)
    assert_allclose(data.body("tool0").xmat.reshape(3, 3)[:, 2], [1.0, 0.0, 0.0], atol=1e-12)


@pytest.mark.parametrize("joint", [1, 2])
def test_positive_j2_and_j3_lower_the_arm_forward(joint):
    """From the zero pose, J2 and J3 turned forward bring the flange down (note 105c, figure 3)."""
    qpos = np.zeros(6)
    qpos[joint] = 0.1
    assert ROBOT.end_effector(qpos)[2] < ROBOT.end_effector(np.zeros(6))[2] - 0.05


def test_axes_at_the_zero_pose(model, data):
    """The axes point along z, y, y, x, y, x."""
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    x, y, z = np.eye(3)
    assert_allclose(data.xaxis, [z, y, y, x, y, x], atol=1e-12)


@settings(deadline=None)
@given(POSES, st.floats(-math.pi, math.pi))
def test_turning_j1_turns_the_end_effector_about_z(qpos, angle):
    """J1 turned by any angle turns the flange about the world's z axis by that angle."""
    c, s = math.cos(angle), math.sin(angle)
    turned = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ ROBOT.end_effector(qpos)
    assert_allclose(ROBOT.end_effector(np.add(qpos, [angle, 0, 0, 0, 0, 0])), turned, atol=1e-12)


@settings(deadline=None)
@given(POSES)
def test_turning_j6_moves_nothing(qpos):
    """The flange's centre is on axis 6."""
    assert_allclose(ROBOT.jacobian(qpos)[:, 5], 0.0, atol=1e-12)


@settings(deadline=None)
@given(POSES)
def test_end_effector_stays_within_reach(qpos):
    """No pose in range brings the flange farther from axis 1 at shoulder height than `reach`."""
    assert norm(ROBOT.end_effector(qpos) - [0.0, 0.0, 0.43]) <= ROBOT.reach


def test_reach_is_that_of_an_arm_of_this_size():
    """The reach to the wrist, a1 + a2 + hypot(a3, d4), is about 1.4 m; d6 comes on top."""
    wrist = 0.18 + 0.61 + math.hypot(0.12, 0.63)
    assert wrist == pytest.approx(1.43, abs=0.01)
    assert ROBOT.reach == pytest.approx(wrist + 0.11, rel=1e-12)


def test_limits_are_the_published_degrees():
    """The ranges are those of the slides, to the last bit of a double."""
    published = [(-100, 100), (-60, 135), (-80, 80), (-160, 160), (-135, 135), (-360, 360)]
    limits = list(zip(ROBOT.lower.tolist(), ROBOT.upper.tolist(), strict=True))
    assert limits == [(math.radians(low), math.radians(high)) for low, high in published]


def test_names_of_joints_and_links():
    """Six joints in order, from base_link to tool0."""
    assert ROBOT.joint_names == ("joint1", "joint2", "joint3", "joint4", "joint5", "joint6")
    assert [link.get("name") for link in LINKS] == ["base_link", *MOVING]
    assert (ROBOT.name, ROBOT.end_effector_link) == ("fd100", "tool0")


def test_home_is_clear_of_the_ground(model, data):
    """At home every moving link is at least 0.05 m above the ground, and stays so when only J1 turns."""
    for j1 in np.linspace(ROBOT.lower[0], ROBOT.upper[0], 21):
        assert _height_above_ground(model, data, np.array([j1, *ROBOT.home[1:]])) >= 0.05


def test_lowered_arm_touches_the_ground(model, data):
    """Heights and contacts are really measured: the arm bent down fully is below the ground and in contact with it."""
    assert _height_above_ground(model, data, np.radians([0, 135, 0, 0, 0, 0])) < 0.0
    assert data.ncon > 0


def test_base_stands_on_the_ground(model, data):
    """The foot plate's lower face is the ground plane."""
    mujoco.mj_forward(model, data)
    base = [geom for geom in range(model.ngeom) if model.body(model.geom_bodyid[geom]).name == "base_link"]
    heights = [mujoco.mj_geomDistance(model, data, model.geom("ground").id, geom, 3.0, None) for geom in base]
    assert min(heights) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("arm_deg", [(0, 0, 0), (0, 10, 10), (60, 40, -60)])
def test_links_do_not_run_into_one_another(model, data, arm_deg):
    """With the arm clear of itself, no wrist pose in range brings two links that are not neighbours into contact."""
    for qpos in _random_poses(300):
        data.qpos[:] = [*np.radians(arm_deg), *qpos[3:]]
        mujoco.mj_forward(model, data)
        assert data.ncon == 0


def test_visual_and_collision_shapes_are_the_same():
    """What is seen is what collides."""
    for link in LINKS:
        shapes = {tag: [_shape(element) for element in link.findall(tag)] for tag in ("visual", "collision")}
        assert shapes["visual"] == shapes["collision"] != []


def _shape(element):
    return [re.sub(r"\s+", "", ElementTree.tostring(element.find(tag), "unicode")) for tag in ("origin", "geometry")]


def test_masses_are_those_of_an_arm_of_this_size():
    """The arm weighs 100 to 180 kg, and no link weighs more than the one that carries it."""
    masses = [float(link.find("inertial/mass").get("value")) for link in LINKS]
    assert 100.0 <= sum(masses) <= 180.0
    assert all(inner >= outer > 0.0 for inner, outer in pairwise(masses))


def test_inertia_is_that_of_the_first_shape_when_solid(subtests):
    """Each inertia is that of the link's whole mass in its first shape, about that shape's centre, along its axes."""
    for link in LINKS:
        with subtests.test(link=link):
            mass = float(link.find("inertial/mass").get("value"))
            inertia = {name: float(value) for name, value in link.find("inertial/inertia").attrib.items()}
            assert link.find("inertial/origin").attrib == link.find("collision/origin").attrib
            solid = mass / 12.0 * np.array(_squares(link.find("collision/geometry")[0]))
            assert_allclose([inertia["ixx"], inertia["iyy"], inertia["izz"]], solid, rtol=1e-5)
            assert inertia["ixy"] == inertia["ixz"] == inertia["iyz"] == 0.0


def _squares(shape):
    """Twelve times a solid's squared radii of gyration about x, y and z [m^2]."""
    if shape.tag == "box":
        x, y, z = map(float, shape.get("size").split())
        return y * y + z * z, x * x + z * z, x * x + y * y
    radius, length = float(shape.get("radius")), float(shape.get("length"))
    return 3 * radius**2 + length**2, 3 * radius**2 + length**2, 6 * radius**2


def test_inertia_can_exist(subtests):
    """Each inertia is positive definite, and no principal moment exceeds the sum of the other two."""
    for link in LINKS:
        with subtests.test(link=link):
            i = {name: float(value) for name, value in link.find("inertial/inertia").attrib.items()}
            tensor = [[i["ixx"], i["ixy"], i["ixz"]], [i["ixy"], i["iyy"], i["iyz"]], [i["ixz"], i["iyz"], i["izz"]]]
            moments = np.linalg.eigvalsh(tensor)
            assert moments[0] > 0.0
            assert moments[2] <= moments[0] + moments[1]
