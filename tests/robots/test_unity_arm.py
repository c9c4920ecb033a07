"""The unity-arm against the original's own figures, in Unity's frame."""

import json
import math
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest
from numpy.linalg import norm
from numpy.random import default_rng
from numpy.testing import assert_allclose

import harness_robots
from harness.robot import forward
from harness.robot.robot import read_robot
from tests.registered import UNITY_ARM

ROBOT = read_robot(harness_robots.UNITY_ARM)
LINKS = {link.get("name"): link for link in ElementTree.fromstring(ROBOT.urdf).findall("link")}
ORIGINAL = json.loads(Path(__file__).with_name("unity_arm_nodes.json").read_text())
COLLIDING = {"Axis02": "Box003", "Axis03": "Line010", "Axis04": "Cylinder011", "Axis05": "Rotor"}
CAPSULES = [next(each for each in ORIGINAL["colliders"] if each["node"] == node) for node in COLLIDING.values()]

# The chain of the original's prefab, computed in Unity's frame: five angles [deg], the end effector [m].
CHECK_POINTS = [
    (
        (49.344660000000005, 83.85705, 99.9261, 83.15685, 7.66548),
        (0.027084387875557954, 0.38174010063606156, 0.08439508302492407),
    ),
    (
        (-157.22657999999998, 5.31342, 29.022479999999998, -40.02129, 1.7113500000000001),
        (0.0906920777975618, 1.0677386306409689, -0.1761890239591349),
    ),
    (
        (0.3888, -70.32924, 111.3372, -10.75572, -62.61192),
        (-0.11346151635157431, -0.09901119252522417, -0.4829661298700534),
    ),
    (
        (-143.84916, -12.69585, -86.5413, 80.73756, -88.15851),
        (0.09868445305755524, 0.8634815015495615, -0.1512612017247227),
    ),
    (
        (-42.944759999999995, 71.79992999999999, 28.73952, 30.25287, -22.8852),
        (-0.48637518543109887, 0.7240358813030745, 0.27094391284421926),
    ),
    (
        (-128.37438, 28.59741, -103.05648000000001, 64.12185, 61.71003),
        (-0.3943334674634914, 0.47564055054950094, -0.5480692884399426),
    ),
    (
        (-146.66094, 62.99667, -48.82769999999999, 45.73656, -65.52620999999999),
        (-0.32052912803684447, 0.4600896943421425, -0.7878977749260555),
    ),
    (
        (-58.5684, 37.78119, -165.28536, -50.995349999999995, -38.08449),
        (-0.023883899839852125, 0.2482787942866394, -0.20431763684632862),
    ),
    (
        (7.85502, -23.45382, 63.298080000000006, 36.22716, -27.29817),
        (-0.18844998198300061, 0.4402005461326736, -0.6394766177208433),
    ),
    (
        (-89.28648, -61.69833, -84.81852, 70.51653, 46.00494),
        (0.46573685786553026, 0.7788721668040773, -0.2074584536520404),
    ),
    (
        (100.23246, -56.53583999999999, 32.56038, -31.65597, 61.23051),
        (-0.6958304795908534, 0.6172827004944803, 0.15589967465896373),
    ),
    (
        (-12.56058, 29.67273, -121.44546, 38.75787, -67.07556),
        (-0.22780627296585448, 0.3729801147508741, 0.4243733274996597),
    ),
    # what the experimenters wrote down of their fixed start
    ((-18, 9, -18, 9, 9), (-0.185766, 1.049303, 0.1233658)),
]


@pytest.fixture(scope="module")
def model():
    """The arm on a ground plane, every link a body of its own that touches the ground alone."""
    spec = mujoco.MjSpec.from_string(ROBOT.urdf)
    spec.compiler.fusestatic = False
    for geom in spec.geoms:
        geom.contype, geom.conaffinity = 1, 0
    spec.worldbody.add_geom(name="ground", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[3.0, 3.0, 0.1], contype=0)
    return spec.compile()


def _random_poses(count):
    return default_rng(105).uniform(ROBOT.lower, ROBOT.upper, (count, ROBOT.dof))


def _mirrored(unity):
    """A point or direction of Unity's frame in the project's."""
    x, y, z = unity
    return np.array([z, -x, y])


def _turned(quaternion_xyzw, vector):
    """The vector turned by the quaternion, whose length need not be 1."""
    x, y, z, w = np.array(quaternion_xyzw) / norm(quaternion_xyzw)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    twice = 2.0 * cross @ vector
    return vector + w * twice + cross @ twice


def _unity_point(node, point, qpos):
    """Where a point of a node, lengths scaled, is in Unity's world [m]: outwards from the node to the root."""
    chain = ORIGINAL["chain"]
    names = [each["node"] for each in chain]
    path = chain[: names.index("Axis05" if node == "Rotor" else node) + 1]
    for each in reversed([*path, ORIGINAL["rotor_on_axis05"]] if node == "Rotor" else path):
        if "joint" in each:
            half = qpos[each["joint"] - 1] / 2.0
            point = _turned([0.0, 0.0, math.sin(half), math.cos(half)], point)
        point = ORIGINAL["root_scale"] * np.array(each["position"]) + _turned(each["quaternion_xyzw"], point)
    return point


def _capsule_ends(capsule, qpos):
    """Centres of a collider's two half spheres, in the project's frame [m], shape (2, 3)."""
    scale = ORIGINAL["root_scale"]
    half = np.eye(3)["xyz".index(capsule["axis"])] * (capsule["height"] / 2.0 - capsule["radius"])
    ends = [scale * (np.array(capsule["center"]) + sign * half) for sign in (1.0, -1.0)]
    return np.array([_mirrored(_unity_point(capsule["node"], end, qpos)) for end in ends])


def test_end_effector_is_that_of_the_original(subtests):
    """At the same angles in degrees the end effector is the mirror image of the original's."""
    for angles_deg, unity in CHECK_POINTS:
        with subtests.test(angles_deg=angles_deg):
            assert_allclose(ROBOT.end_effector(np.radians(angles_deg)), _mirrored(unity), rtol=0.0, atol=1e-6)


def test_home_is_the_recorded_start():
    """Home is the fixed start of the published experiment."""
    assert ROBOT.home.tolist() == [math.radians(angle) for angle in (-18, 9, -18, 9, 9)]
    assert_allclose(ROBOT.end_effector(ROBOT.home), [0.1233658, 0.185766, 1.049303], rtol=0.0, atol=1e-6)


def test_pose_is_the_mirror_image_of_the_original():
    """On 200 random poses the end effector's place and its three axes are those of the original's chain, mirrored."""
    for qpos in _random_poses(200):
        pose = forward(ROBOT.chain, qpos)
        tip = _unity_point("Axis06Tip", np.zeros(3), qpos)
        assert_allclose(pose[:3, 3], _mirrored(tip), rtol=0.0, atol=1e-12)
        for axis in np.eye(3):
            direction = _unity_point("Axis06Tip", axis, qpos) - tip
            assert_allclose(pose[:3, :3] @ _mirrored(axis), _mirrored(direction), rtol=0.0, atol=1e-12)


def test_jacobian_is_the_difference_quotient():
    """On 50 random poses a small turn of a joint moves the end effector as the Jacobian says."""
    step = 1e-5 * np.eye(ROBOT.dof)
    for qpos in _random_poses(50):
        quotient = (ROBOT.end_effector(qpos + step) - ROBOT.end_effector(qpos - step)).T / 2e-5
        assert_allclose(ROBOT.jacobian(qpos), quotient, rtol=0.0, atol=1e-9)


def test_limits_are_the_action_scale():
    """A full action is a joint's limit: 180, 90, 180, 90, 90 degrees either way, to the last bit of a double."""
    limits = [math.radians(angle) for angle in (180, 90, 180, 90, 90)]
    assert ROBOT.upper.tolist() == limits
    assert ROBOT.lower.tolist() == [-limit for limit in limits]


def test_names_of_joints_and_links():
    """Five joints in order, links named for the original's nodes, and the robot found by its name."""
    assert ROBOT.joint_names == ("joint1", "joint2", "joint3", "joint4", "joint5")
    assert list(LINKS) == ["RobotWithColliders", "Axis01", "Axis02", "Axis03", "Axis04", "Axis05", "Axis06Tip"]
    assert (ROBOT.name, ROBOT.end_effector_link) == ("unity-arm", "Axis06Tip")
    assert UNITY_ARM.urdf == ROBOT.urdf


def test_only_the_colliders_of_the_original_collide():
    """Each capsule is a cylinder with a sphere at either end, the end effector a sphere; nothing else collides."""
    shapes = {name: [each[0].tag for each in link.findall("collision/geometry")] for name, link in LINKS.items()}
    capsule = ["cylinder", "sphere", "sphere"]
    expected = {"RobotWithColliders": [], "Axis01": [], "Axis06Tip": ["sphere"]} | dict.fromkeys(COLLIDING, capsule)
    assert shapes == expected


@pytest.mark.parametrize(("link", "capsule"), list(zip(COLLIDING, CAPSULES, strict=True)), ids=COLLIDING)
@pytest.mark.parametrize("at_home", [False, True])
def test_capsules_are_where_the_original_has_them(model, data, link, capsule, at_home):
    """At the zero pose and at home, MuJoCo has spheres at the capsule's ends and a cylinder from one to the other."""
    qpos = ROBOT.home if at_home else np.zeros(ROBOT.dof)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(model, data)
    first = model.body(link).geomadr[0]
    cylinder, *spheres = range(first, first + 3)
    ends = _capsule_ends(capsule, qpos)
    span = ends[0] - ends[1]
    radius = ORIGINAL["root_scale"] * capsule["radius"]
    assert_allclose(data.geom_xpos[spheres], ends, rtol=0.0, atol=1e-9)
    assert_allclose(data.geom_xpos[cylinder], ends.mean(axis=0), rtol=0.0, atol=1e-9)
    assert_allclose(np.cross(data.geom_xmat[cylinder].reshape(3, 3)[:, 2], span), 0.0, atol=1e-9)
    assert_allclose(model.geom_size[cylinder, :2], [radius, norm(span) / 2.0], rtol=1e-9)
    assert_allclose(model.geom_size[spheres, 0], radius, rtol=1e-12)


def test_sphere_is_at_the_end_effector(model, data):
    """The end effector's collider is a sphere of 15 mm about it."""
    mujoco.mj_kinematics(model, data)
    (first,) = model.body("Axis06Tip").geomadr
    assert_allclose(data.geom_xpos[first], ROBOT.end_effector(np.zeros(5)), rtol=0.0, atol=1e-9)
    assert model.geom_size[first, 0] == 0.015


def test_ground_is_touched_where_the_original_touches_it(model, data):
    """On 300 random poses MuJoCo reports a ground contact exactly if a collider of the original is below the ground."""
    touched = []
    for qpos in _random_poses(300):
        data.qpos[:] = qpos
        mujoco.mj_forward(model, data)
        heights = [_unity_point("Axis06Tip", np.zeros(3), qpos)[1] - 0.015]
        heights += [
            _capsule_ends(each, qpos)[:, 2].min() - ORIGINAL["root_scale"] * each["radius"] for each in CAPSULES
        ]
        touched.append(data.ncon > 0)
        assert touched[-1] == (min(heights) < 0.0)
    assert 20 <= sum(touched) <= 280


def test_home_is_clear_of_the_ground(model, data):
    """At home, whatever the turn of axis 1, every collider is at least 0.05 m above the ground."""
    ground = model.geom("ground").id
    for turn in np.linspace(-math.pi, math.pi, 21):
        data.qpos[:] = [turn, *ROBOT.home[1:]]
        mujoco.mj_forward(model, data)
        shapes = set(range(model.ngeom)) - {ground}
        assert min(mujoco.mj_geomDistance(model, data, ground, shape, 3.0, None) for shape in shapes) >= 0.05


def test_what_collides_is_seen():
    """A link's visual shapes are its collision shapes, where it has any."""
    for link in LINKS.values():
        seen, colliding = ([_shape(each) for each in link.findall(tag)] for tag in ("visual", "collision"))
        assert seen
        assert colliding in ([], seen)


def _shape(element):
    """Where and what a visual or collision element is."""
    solid = element.find("geometry")[0]
    return element.find("origin").attrib, solid.tag, solid.attrib


def test_masses_are_those_of_an_arm_of_this_size():
    """The arm weighs 15 to 25 kg, and no link weighs more than the one that carries it."""
    masses = [float(link.find("inertial/mass").get("value")) for link in LINKS.values()]
    assert 15.0 <= sum(masses) <= 25.0
    assert all(inner >= outer > 0.0 for inner, outer in pairwise(masses))


def test_inertia_is_that_of_the_solid_shape(subtests):
    """Each inertia is that of the link's whole mass in its shape; real, since no moment exceeds the other two."""
    for case, link in LINKS.items():
        with subtests.test(case):
            i = {name: float(value) for name, value in link.find("inertial/inertia").attrib.items()}
            moments = np.array([i["ixx"], i["iyy"], i["izz"]])
            assert link.find("inertial/origin").attrib == link.find("visual/origin").attrib
            assert_allclose(moments, float(link.find("inertial/mass").get("value")) * _squares(link), rtol=1e-5)
            assert i["ixy"] == i["ixz"] == i["iyz"] == 0.0
            assert 0.0 < max(moments) <= sum(moments) - max(moments)


def _squares(link):
    """Squared radii of gyration about x, y and z [m^2], by summing thin discs across the shape's z axis."""
    first, *ends = [each[0] for each in link.findall("visual/geometry")]
    radius = float(first.get("radius"))
    half = float(first.get("length", "0")) / 2.0
    top = half + radius if ends or first.tag == "sphere" else half
    edges = np.linspace(-top, top, 20_001)
    z = (edges[:-1] + edges[1:]) / 2.0
    disc = radius**2 - np.maximum(np.abs(z) - half, 0.0) ** 2  # squared radius
    along = (disc * disc / 2.0).sum() / disc.sum()
    across = (disc * (disc / 4.0 + z * z)).sum() / disc.sum()
    return np.array([across, across, along])
