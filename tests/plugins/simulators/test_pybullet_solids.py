"""PyBullet has the harness's solids: whatever a mesh's format, each touches the ground where its points do."""

import struct
from contextlib import ExitStack, closing
from itertools import product

import numpy as np
import pybullet
import pytest
from numpy.random import default_rng
from numpy.testing import assert_array_equal

from harness.errors import MissingSolid
from harness.robot import build_solids, link_frames
from harness.robot.robot import read_robot
from harness_plugins.simulators.pybullet import PyBullet
from tests.registered import FD100

CORNERS = np.array([[x, y, z] for x in (-0.03, 0.03) for y in (-0.03, 0.03) for z in (0.0, 0.3)])
"""Of a rod, [m]."""
SIDES = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6],
                  [0, 6, 4], [1, 5, 7], [1, 7, 3]])  # fmt: skip
"""Its triangles."""


@pytest.fixture
def open_arms():
    """Opens a simulation, which is closed at the end."""
    with ExitStack() as opened:
        yield lambda robot: opened.enter_context(closing(PyBullet().open(robot, 1, 0.1)))


def text_stl(points):
    """As most programs export one."""
    corners = "".join(
        "facet normal 0 0 0\n outer loop\n"
        + "".join("  vertex {:.6g} {:.6g} {:.6g}\n".format(*points[corner]) for corner in side)
        + " endloop\nendfacet\n"
        for side in SIDES
    )
    return f"solid rod\n{corners}endsolid rod\n".encode()


def binary_stl(points):
    """The same, binary."""
    rows = (struct.pack("<12fH", 0, 0, 0, *points[side].ravel(), 0) for side in SIDES)
    return bytes(80) + struct.pack("<I", len(SIDES)) + b"".join(rows)


def obj(points, group=""):
    """With a group before every second side, if it has a name."""
    lines = ["v {:.6g} {:.6g} {:.6g}".format(*point) for point in points]
    for number, side in enumerate(SIDES + 1):
        lines += [f"{group} part{number}"] * bool(group and number % 2 == 0) + ["f {} {} {}".format(*side)]
    return ("\n".join(lines) + "\n").encode()


MESHES = {
    "text.stl": text_stl(CORNERS),
    "binary.stl": binary_stl(CORNERS),
    "plain.obj": obj(CORNERS),
    "objects.obj": obj(CORNERS, "o"),
    "points.obj": "".join("v {} {} {}\n".format(*point) for point in CORNERS).encode(),
    "UPPER.STL": text_stl(CORNERS),
}
ATTRIBUTES = ('concave="yes"', 'group="0" mask="0"')
"""Of a <collision>, which only Bullet knows."""


@pytest.fixture
def rods(tmp_path):
    """A folder with all meshes, and one that is three times as large."""
    for name, content in {**MESHES, "big.stl": text_stl(3.0 * CORNERS)}.items():
        (tmp_path / name).write_bytes(content)
    return tmp_path


def arm(folder, mesh="text.stl", attributes="", scale="1 1 1", visual=""):
    """Three joints, and a mesh as the only shape of the tool."""
    inertial = (
        '<inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    links = "".join(f'<link name="{name}">{inertial}</link>' for name in ("base", "l1", "l2", "l3"))
    joints = "".join(
        f'<joint name="j{k}" type="revolute"><parent link="{parent}"/><child link="l{k}"/><origin xyz="0 0 0.2"/>'
        f'<axis xyz="{axis}"/><limit lower="-2" upper="2" velocity="2" effort="50"/></joint>'
        for k, (parent, axis) in enumerate((("base", "0 0 1"), ("l1", "0 1 0"), ("l2", "0 1 0")), 1)
    )
    shape = f'<geometry><mesh filename="{mesh}" scale="{scale}"/></geometry>'
    tool = (
        f'<link name="tool">{visual}<collision {attributes}><origin xyz="0.02 0 0" rpy="0.1 0.2 0"/>{shape}</collision>'
        '</link><joint name="jt" type="fixed"><parent link="l3"/><child link="tool"/><origin xyz="0.05 0 0.1"/></joint>'
    )
    path = folder / "arm.urdf"
    path.write_text(f'<robot name="arm">{links}{joints}{tool}</robot>')
    return read_robot(path)


def heights(robot, poses):
    """Of the lowest point of the solids, by the harness alone, [m]."""
    return build_solids(robot.joint_shapes).lowest(link_frames(robot.chain, poses))


def touching(open_arms, robot, poses):
    """Whether the arm touches the ground at each pose."""
    simulation = open_arms(robot)
    return np.array([simulation.place(pose[None]).ground_contact[0] for pose in poses])


def poses_near_the_ground(robot):
    """Poses whose lowest point is 0.2 to 30 mm above or below the ground."""
    poses = default_rng(0).uniform(robot.lower, robot.upper, (20_000, robot.dof))
    height = np.abs(heights(robot, poses))
    near = poses[(height > 2e-4) & (height < 0.03)]
    assert len(near) > 50
    return near[:200]


@pytest.mark.parametrize(
    ("name", "attributes", "scale"),
    [*product(MESHES, [""], ["1 1 1", "-0.7 1.5 0.8"]), *(("text.stl", it, "1 1 1") for it in ATTRIBUTES)],
)
def test_a_mesh_of_any_format_touches_where_its_points_do(rods, open_arms, name, attributes, scale):
    """Text and binary STL, an OBJ of one object or several or of points alone: contact to 0.2 mm.

    A solid that Bullet alone would take for another, or for one that touches nothing, is the same solid.
    """
    robot = arm(rods, name, attributes, scale)
    poses = poses_near_the_ground(robot)
    assert_array_equal(touching(open_arms, robot, poses), heights(robot, poses) < 0.0)


@pytest.mark.parametrize("name", ["v.glb", "v.ply", "v.gltf"])
def test_a_drawing_that_bullet_cannot_read_is_left_out(rods, open_arms, name):
    """The arm moves and is drawn without it."""
    (rods / name).write_bytes(b"glTF")
    robot = arm(rods, visual=f'<visual><geometry><mesh filename="{name}"/></geometry></visual>')
    assert open_arms(robot).render(0, np.zeros(3), 32, 24).shape == (24, 32, 3)


def test_a_drawing_has_light_and_shade(rods, open_arms):
    """An STL of which Bullet is told no normals would be black, whatever its colour."""
    red = '<material name="red"><color rgba="1 0 0 1"/></material>'
    visual = f'<visual><geometry><mesh filename="big.stl"/></geometry>{red}</visual>'
    frame = open_arms(arm(rods, visual=visual)).render(0, np.full(3, 99.0), 80, 60).astype(int)
    assert (frame[..., 0] > frame[..., 1] + 60).any()
    assert not (frame.max(axis=2) < 20).any()


def test_a_drawing_in_a_text_stl_is_drawn(rods, open_arms):
    """A frame with the drawing differs from one of the solid alone, which is drawn where a link has no drawing."""
    big = '<visual><geometry><mesh filename="big.stl"/></geometry></visual>'
    frames = [open_arms(arm(rods, visual=it)).render(0, np.zeros(3), 64, 48) for it in ("", big)]
    assert (frames[0] != frames[1]).mean() > 0.01


def test_a_solid_that_bullet_drops_is_an_error_that_names_the_link(rods, open_arms, monkeypatch):
    """As a text STL, which Bullet takes for nothing."""
    monkeypatch.setattr("harness_plugins.bullet_arms.arm_file._write_stl", lambda *_: str(rods / "text.stl"))
    with pytest.raises(MissingSolid, match="0 of the 1 collision shapes of link 'tool' of robot 'arm'"):
        open_arms(arm(rods))


def test_the_arm_of_primitive_shapes_is_read_as_it_was(open_arms):
    """No margin is changed, and no shape is written anew."""
    simulation = open_arms(FD100)
    (own,) = simulation.arms
    kinds = {
        shape[2]
        for link in range(-1, pybullet.getNumJoints(own.body, physicsClientId=own.client))
        for shape in pybullet.getCollisionShapeData(own.body, link, physicsClientId=own.client)
    }
    assert kinds
    assert pybullet.GEOM_MESH not in kinds


def test_what_bullet_prints_about_a_file_is_visible(rods, open_arms, capfd):
    """Bullet warns of a joint without an axis by its name, which may hold what moves a terminal's cursor."""
    text = arm(rods).urdf.replace('<axis xyz="0 0 1"', "<axis-of-old", 1)
    (rods / "arm.urdf").write_text(text.replace('"j1"', '"j1\u202e\x9b2J"'))
    open_arms(read_robot(rods / "arm.urdf"))
    printed = capfd.readouterr()
    assert printed.out == ""
    assert "j1\\u202e\\x9b2J" in printed.err
    assert not {"\u202e", "\x9b"} & set(printed.err)
