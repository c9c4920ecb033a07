"""Collision shapes of a URDF and the joints that move them."""

import re
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial import ConvexHull

from harness.robot import parse_urdf
from harness.robot.kinematics import transform
from harness.robot.shapes import attach_shapes, read_shapes
from tests.refusals import refused


def test_all_kinds_are_read(arm_text):
    """Each link has its shapes in the order of the file, with kind and size."""
    links = read_shapes(parse_urdf(arm_text))
    found = {link: [(shape.kind, shape.size) for shape in shapes] for link, shapes in links.items()}
    assert found == {
        "base": [("sphere", (9.0,))],
        "foot": [("sphere", (8.0,))],
        "upper": [("box", (0.1, 0.2, 0.3)), ("cylinder", (0.05, 0.4))],
        "slider": [("capsule", (0.04, 0.2))],
        "bracket": [],
        "flange": [],
        "tip": [("sphere", (0.07,))],
        "finger": [("sphere", (7.0,))],
    }


def test_origin_is_the_transform(arm_text):
    """A shape's origin is read as a joint's; without one the shape sits in the link's frame."""
    box, cylinder = read_shapes(parse_urdf(arm_text))["upper"]
    assert_allclose(box.T_link_shape, transform((0.1, 0.2, 0.3), (0.4, 0.5, 0.6)), atol=1e-15)
    assert_array_equal(box.T_link_shape[:3, 3], [0.1, 0.2, 0.3])
    assert_array_equal(cylinder.T_link_shape, np.eye(4))


def test_shapes_move_with_their_joints(attached):
    """What no joint moves is left out, what is fixed to a moving link is in, what another joint moves is out."""
    assert [[shape.kind for shape in shapes] for shapes in attached] == [["box", "cylinder"], ["capsule"], ["sphere"]]


def test_shapes_cannot_be_changed(tmp_path, arm_text, attached):
    """Nothing can be written to a shape's arrays, neither as they are read nor as they are attached."""
    (tmp_path / "part.obj").write_text("v 1 2 3\n")
    mesh = upper_shapes(arm_text, f'<mesh filename="{tmp_path}/part.obj"/>')
    for shape in (*mesh, *(shape for group in attached for shape in group)):
        for array in (shape.T_link_shape, shape.points):
            with pytest.raises(ValueError, match="read-only"):
                array[:] = 0.0


def test_shape_of_a_fixed_link_is_in_the_frame_of_its_joint(attached):
    """The end effector's sphere at y = 0.1, 0.2 m along y from a flange that is turned at x = 1, is at x = 0.7."""
    (sphere,) = attached[2]
    assert_allclose(sphere.T_link_shape[:3, 3], [0.7, 0.0, 0.0], atol=1e-15)


def test_malformed_shape_is_a_usage_error(arm_text, subtests):
    """One line names the link, what was given and what belongs there."""
    for good, bad, message in [
        ('<box size="0.1 0.2 0.3"/>', '<box size="0.1 0.2"/>', "3 finite numbers"),
        ('<box size="0.1 0.2 0.3"/>', "<box/>", "3 finite numbers"),
        ('<box size="0.1 0.2 0.3"/>', '<box size="0.1 -0.2 0.3"/>', "positive"),
        ('<box size="0.1 0.2 0.3"/>', '<box size="0.1 wide 0.3"/>', "wide"),
        ('<box size="0.1 0.2 0.3"/>', '<box size="0.1 nan 0.3"/>', "nan"),
        ('<box size="0.1 0.2 0.3"/>', "", "without one shape"),
        ('<geometry><box size="0.1 0.2 0.3"/></geometry>', "", "without one shape"),
        ('<box size="0.1 0.2 0.3"/>', "<cone/>", "<cone>; allowed: box, cylinder, capsule, sphere, mesh"),
        ('<cylinder radius="0.05" length="0.4"/>', '<cylinder radius="0.05"/>', "<cylinder length=...>"),
        ('<cylinder radius="0.05" length="0.4"/>', '<cylinder radius="0" length="0.4"/>', "<cylinder radius=...>"),
        ('xyz="0.1 0.2 0.3" rpy', 'xyz="0.1 0.2" rpy', "<origin>"),
        ('rpy="0.4 0.5 0.6"/> <geometry>', 'rpy="a b c"/> <geometry>', "<origin>"),
    ]:
        with subtests.test(good=good):
            assert arm_text.count(good) == 1
            with refused(re.escape(message)) as caught:
                read_shapes(parse_urdf(arm_text.replace(good, bad)))
            assert str(caught.value).startswith("Link 'upper' ")


def test_malformed_fixed_joint_is_a_usage_error(arm_text):
    """The origin of a fixed joint beside the chain is checked as well."""
    urdf = parse_urdf(arm_text.replace('xyz="1 0 0"', 'xyz="1 0"'))
    with refused("Joint 'mount' has '1 0'"):
        attach_shapes(urdf, read_shapes(urdf), ("turn",))


def upper_shapes(arm_text, mesh):
    """Those of the link ``upper``, a mesh in the place of its cylinder."""
    return read_shapes(parse_urdf(arm_text.replace('<cylinder radius="0.05" length="0.4"/>', mesh)))["upper"]


def test_mesh_is_its_points_scaled(tmp_path, arm_text):
    """A mesh collides as the points of its file, times the scale, each once; its origin is read as of other shapes."""
    (tmp_path / "part.obj").write_text("v 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 2 3\nf 1 2 3\n")
    mesh = upper_shapes(arm_text, f'<mesh filename="{tmp_path}/part.obj" scale="0.1 1 -2"/>')[1]
    assert (mesh.kind, mesh.size) == ("mesh", ())
    assert_array_equal(mesh.points, [[0, 0, 0], [0, 1, 0], [0.1, 0, 0], [0.1, 2, -6]])


@pytest.mark.parametrize("corners", ["v 1 2 3\nv 2 2 3\nv 1 3 4\n", "v 1 2 3\nv 2 4 6\nv 3 6 9\n"])
def test_a_flat_mesh_is_a_sheet(tmp_path, arm_text, corners):
    """A plate or a wire has no hull that an engine can build: it gets a millimetre of thickness, on both sides."""
    (tmp_path / "part.obj").write_text(f"{corners}f 1 2 3\n")
    mesh = upper_shapes(arm_text, f'<mesh filename="{tmp_path}/part.obj" scale="0.1 0.1 0.1"/>')[1]
    given = 0.1 * np.array([line.split()[1:] for line in corners.splitlines()], float)
    assert_allclose(mesh.points.mean(axis=0), given.mean(axis=0))
    thinnest = np.linalg.svd(mesh.points - mesh.points.mean(axis=0))[2][-1]
    assert 1e-3 - 1e-9 <= np.ptp(mesh.points @ thinnest) < 1.5e-3
    assert ConvexHull(mesh.points).volume > 1e-7


@pytest.mark.parametrize(
    ("mesh", "message"),
    [
        ('<mesh filename="part.dae"/>', "Link 'upper' has a collision mesh: 'part.dae' cannot be read as a mesh"),
        ('<mesh filename="none.stl"/>', "'none.stl' cannot be read as a mesh"),
        ('<mesh filename="part.obj" scale="1 1"/>', "'1 1' in <mesh scale=...>, where 3 finite numbers belong"),
        ('<mesh filename="part.obj" scale="1 0 1"/>', "'1 0 1' in <mesh scale=...>. Give factors that are not 0."),
    ],
)
def test_mesh_that_cannot_collide_is_refused(tmp_path, monkeypatch, arm_text, mesh, message):
    """One line names the link, the file, and what to do."""
    monkeypatch.chdir(tmp_path)
    Path("part.obj").write_text("v 1 2 3\n")
    with refused(re.escape(message)):
        upper_shapes(arm_text, mesh)
