"""Collision shapes of a URDF and the joints that move them."""

import re
from pathlib import Path

import numpy as np
import pytest

from harness.errors import UsageError
from harness.robot.kinematics import transform
from harness.robot.shapes import attach_shapes, read_shapes

ARM = """
<robot name="arm">
  <link name="base"><collision><geometry><sphere radius="9"/></geometry></collision></link>
  <link name="foot"><collision><geometry><sphere radius="8"/></geometry></collision></link>
  <link name="upper">
    <collision>
      <origin xyz="0.1 0.2 0.3" rpy="0.4 0.5 0.6"/> <geometry><box size="0.1 0.2 0.3"/></geometry>
    </collision>
    <collision><geometry><cylinder radius="0.05" length="0.4"/></geometry></collision>
  </link>
  <link name="slider">
    <collision><origin rpy="1 0 0"/><geometry><capsule radius="0.04" length="0.2"/></geometry></collision>
  </link>
  <link name="bracket"/> <link name="flange"/>
  <link name="tip"><collision><origin xyz="0 0.1 0"/><geometry><sphere radius="0.07"/></geometry></collision></link>
  <link name="finger"><collision><geometry><sphere radius="7"/></geometry></collision></link>
  <joint name="bolt" type="fixed"> <parent link="base"/> <child link="foot"/> </joint>
  <joint name="turn" type="continuous">
    <parent link="foot"/> <child link="upper"/> <origin xyz="0.1 -0.2 0.3" rpy="0.4 0.5 0.6"/> <axis xyz="0 3 4"/>
  </joint>
  <joint name="slide" type="prismatic">
    <parent link="upper"/> <child link="slider"/>
    <origin xyz="0 0 0.5" rpy="0 1.5707963267948966 0"/> <axis xyz="1 2 0"/> <limit lower="0" upper="0.25"/>
  </joint>
  <joint name="spin" type="revolute">
    <parent link="slider"/> <child link="bracket"/> <axis xyz="0 0 -1"/> <limit lower="-2" upper="2"/>
  </joint>
  <joint name="mount" type="fixed">
    <parent link="bracket"/> <child link="flange"/> <origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/>
  </joint>
  <joint name="weld" type="fixed"> <parent link="flange"/> <child link="tip"/> <origin xyz="0 0.2 0"/> </joint>
  <joint name="grip" type="prismatic">
    <parent link="tip"/> <child link="finger"/> <limit lower="0" upper="0.1"/>
  </joint>
</robot>
"""
JOINTS = ("turn", "slide", "spin")


def test_all_kinds_are_read():
    """Each link has its shapes in the order of the file, with kind and size."""
    found = {link: [(shape.kind, shape.size) for shape in shapes] for link, shapes in read_shapes(ARM).items()}
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


def test_origin_is_the_transform():
    """A shape's origin is read as a joint's; without one the shape sits in the link's frame."""
    box, cylinder = read_shapes(ARM)["upper"]
    expected = transform((0.1, 0.2, 0.3), (0.4, 0.5, 0.6))
    np.testing.assert_allclose(box.T_link_shape, expected, atol=1e-15)
    np.testing.assert_array_equal(box.T_link_shape[:3, 3], [0.1, 0.2, 0.3])
    np.testing.assert_array_equal(cylinder.T_link_shape, np.eye(4))


def test_shapes_move_with_their_joints():
    """What no joint moves is left out, what is fixed to a moving link is in, what another joint moves is out."""
    kinds = [[shape.kind for shape in shapes] for shapes in attach_shapes(ARM, JOINTS)]
    assert kinds == [["box", "cylinder"], ["capsule"], ["sphere"]]


def test_shape_of_a_fixed_link_is_in_the_frame_of_its_joint():
    """The end effector's sphere at y = 0.1, 0.2 m along y from a flange that is turned at x = 1, is at x = 0.7."""
    (sphere,) = attach_shapes(ARM, JOINTS)[2]
    np.testing.assert_allclose(sphere.T_link_shape[:3, 3], [0.7, 0.0, 0.0], atol=1e-15)


@pytest.mark.parametrize(
    ("good", "bad", "message"),
    [
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
    ],
)
def test_malformed_shape_is_a_usage_error(good: str, bad: str, message: str):
    """One line names the link, what was given and what belongs there."""
    assert ARM.count(good) == 1
    with pytest.raises(UsageError, match=re.escape(message)) as caught:
        read_shapes(ARM.replace(good, bad))
    assert str(caught.value).startswith("Link 'upper' ")
    assert "\n" not in str(caught.value)


def test_malformed_fixed_joint_is_a_usage_error():
    """The origin of a fixed joint beside the chain is checked as well."""
    with pytest.raises(UsageError, match="Joint 'mount' has '1 0'"):
        attach_shapes(ARM.replace('xyz="1 0 0"', 'xyz="1 0"'), JOINTS)


def _with_mesh(mesh: str) -> str:
    return ARM.replace('<cylinder radius="0.05" length="0.4"/>', mesh)


def test_mesh_is_its_points_scaled(tmp_path: Path):
    """A mesh collides as the points of its file, times the scale, each once; its origin is read as of other shapes."""
    (tmp_path / "part.obj").write_text("v 1 2 3\nv 0 0 0\nv 1 2 3\nf 1 2 3\n")
    mesh = read_shapes(_with_mesh(f'<mesh filename="{tmp_path}/part.obj" scale="0.1 1 -2"/>'))["upper"][1]
    assert (mesh.kind, mesh.size) == ("mesh", ())
    np.testing.assert_array_equal(mesh.points, [[0, 0, 0], [0.1, 2, -6]])


@pytest.mark.parametrize(
    ("mesh", "message"),
    [
        ('<mesh filename="part.dae"/>', "Link 'upper' has a collision mesh: 'part.dae' is no STL or OBJ file. Convert"),
        ('<mesh filename="none.stl"/>', "'none.stl' cannot be read as a mesh"),
        ('<mesh filename="part.obj" scale="1 1"/>', "'1 1' in <mesh scale=...>, where 3 finite numbers belong"),
        ('<mesh filename="part.obj" scale="1 0 1"/>', "'1 0 1' in <mesh scale=...>. Give factors that are not 0."),
    ],
)
def test_mesh_that_cannot_collide_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, mesh: str, message: str):
    """One line names the link, the file, and what to do."""
    monkeypatch.chdir(tmp_path)
    Path("part.obj").write_text("v 1 2 3\n")
    with pytest.raises(UsageError, match=re.escape(message)) as caught:
        read_shapes(_with_mesh(mesh))
    assert "\n" not in str(caught.value)
