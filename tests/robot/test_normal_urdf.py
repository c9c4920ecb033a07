"""The URDF that simulators read: nothing in it is left to guess."""

from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
import pytest

from harness.errors import UsageError
from harness.robot.kinematics import build_chain, forward
from harness.robot.normal_urdf import plain_urdf
from harness.robot.urdf import read_chain

BODY = '<inertial><mass value="1"/><inertia ixx="1" iyy="2" izz="3" ixy="0" ixz="0" iyz="0"/></inertial>'
URDF = f"""
<robot name="arm">
  <link name="base">{BODY}</link> <link name="arm">{BODY}</link> <link name="finger">{BODY}</link>
  <joint name="turn" type="revolute">
    <parent link="base"/> <child link="arm"/> <limit lower="-1" upper="1" velocity="1"/>
  </joint>
  <joint name="grip" type="prismatic">
    <parent link="arm"/> <child link="finger"/> <origin xyz="0.1 0.2 0.3" rpy="0.4 0.5 0.6"/> <axis xyz="0 3 4"/>
    <limit lower="0.02" upper="0.05" velocity="1"/> <dynamics damping="1"/>
  </joint>
</robot>
"""
FIXED = URDF.replace('"prismatic"', '"fixed"')


def _parts(urdf: str) -> dict[str, Element]:
    """Links and joints by their names."""
    return {part.get("name", ""): part for part in ElementTree.fromstring(urdf)}


def _moments(link: Element) -> list[float]:
    inertia = link.find("inertial/inertia")
    return [float(inertia.get(name)) for name in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")]


def test_plain_text_stays_as_it_is(tmp_path: Path):
    """Where there is nothing to do, the text is the same to the last blank."""
    assert plain_urdf(FIXED, ["turn"], tmp_path) is FIXED


@pytest.mark.parametrize(
    ("kind", "limits", "position"),
    [
        ("prismatic", (0.02, 0.05), 0.02),
        ("prismatic", (-0.05, -0.01), -0.01),
        ("prismatic", (-1.0, 1.0), 0.0),
        ("revolute", (0.7, 1.5), 0.7),
        ("revolute", (-3.0, 1.5), 0.0),
        ("continuous", (0.5, 0.7), 0.0),
    ],
)
def test_other_joints_are_fixed_where_they_are_nearest_to_zero(
    tmp_path: Path, kind: str, limits: tuple[float, float], position: float
):
    """What the joint carries is, in the fixed one, exactly where it was at that position."""
    given = 'lower="{}" upper="{}"'.format(*limits)
    urdf = URDF.replace('"prismatic"', f'"{kind}"').replace('lower="0.02" upper="0.05"', given)
    plain = plain_urdf(urdf, ["turn"], tmp_path)
    grip = _parts(plain)["grip"]
    assert grip.get("type") == "fixed"
    assert {part.tag for part in grip} == {"parent", "child", "origin"}
    before = forward(build_chain(read_chain(urdf, "finger")), [0.3, position])
    np.testing.assert_allclose(forward(build_chain(read_chain(plain, "finger")), [0.3]), before, atol=1e-15)


@pytest.mark.parametrize("kind", ["floating", "planar"])
def test_joints_with_several_ways_to_move_are_fixed_at_zero(tmp_path: Path, kind: str):
    """Beside the chain they may be, and stand still."""
    plain = plain_urdf(URDF.replace('"prismatic"', f'"{kind}"'), ["turn"], tmp_path)
    assert read_chain(plain, "finger")[1].xyz == (0.1, 0.2, 0.3)


def test_joint_that_mimics_is_fixed(tmp_path: Path):
    """A finger that follows another one stands still as that one does, its limits missing or not."""
    urdf = URDF.replace('<dynamics damping="1"/>', '<mimic joint="turn"/>')
    assert _parts(plain_urdf(urdf, ["turn"], tmp_path))["grip"].find("mimic") is None


def test_turned_up_by_a_right_angle(tmp_path: Path):
    """At a pitch of 90 degrees, where roll and yaw are one, the fixed joint still has the same pose."""
    urdf = URDF.replace('rpy="0.4 0.5 0.6"', f'rpy="0.4 {np.pi / 2} 0.6"')
    plain = plain_urdf(urdf, ["turn"], tmp_path)
    before = forward(build_chain(read_chain(urdf, "finger")), [0.0, 0.02])
    np.testing.assert_allclose(forward(build_chain(read_chain(plain, "finger")), [0.0]), before, atol=1e-15)


@pytest.mark.parametrize(
    "body", ["", "<inertial/>", '<inertial><mass value="1"/></inertial>', BODY.replace('value="1"', 'value="0"')]
)
def test_link_without_mass_gets_next_to_none(tmp_path: Path, body: str):
    """No engine is left to take 1 kg, a solid of water, or a part of the ground."""
    finger = _parts(plain_urdf(FIXED.replace(f'"finger">{BODY}', f'"finger">{body}'), ["turn"], tmp_path))["finger"]
    assert [part.tag for part in finger] == ["inertial"]
    assert float(finger.find("inertial/mass").get("value")) == 1e-6


@pytest.mark.parametrize(
    ("moments", "expected"),
    [
        ('ixx="1" iyy="2" izz="6"', [3.0, 3.0, 3.0, 0.0, 0.0, 0.0]),
        ('ixx="0" iyy="0" izz="0"', [1e-9, 1e-9, 1e-9, 0.0, 0.0, 0.0]),
        ('ixx="-1" iyy="2" izz="2"', [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]),
        ('ixx="1" iyy="2" izz="3"', [1.0, 2.0, 3.0, 0.0, 0.0, 0.0]),
    ],
)
def test_inertia_that_no_body_has_becomes_a_balls(tmp_path: Path, moments: str, expected: list[float]):
    """One engine would refuse it, another set it to zero; the mean stays. What a flat plate has stays as it is."""
    urdf = FIXED.replace('"finger">' + BODY, '"finger">' + BODY.replace('ixx="1" iyy="2" izz="3"', moments))
    assert _moments(_parts(plain_urdf(urdf, ["turn"], tmp_path))["finger"]) == pytest.approx(expected)


def test_meshes_have_full_paths(tmp_path: Path):
    """Of what collides and of what is seen, as they lie beside the URDF; scale and the rest stay."""
    (tmp_path / "a.stl").touch()
    shape = '<{0}><geometry><mesh filename="a.stl" scale="1 2 3"/></geometry></{0}>'
    urdf = FIXED.replace(f'"arm">{BODY}', f'"arm">{BODY}{shape.format("visual")}{shape.format("collision")}')
    meshes = list(ElementTree.fromstring(plain_urdf(urdf, ["turn"], tmp_path)).iter("mesh"))
    assert [dict(mesh.attrib) for mesh in meshes] == [{"filename": str(tmp_path / "a.stl"), "scale": "1 2 3"}] * 2


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('mass value="1"', 'mass value="heavy"', "Link 'base' has 'heavy' in <mass value=...>. Give a finite number."),
        ('ixx="1"', 'ixx="nan"', "Link 'base' has 'nan' in <inertia ixx=...>. Give a finite number."),
        ('lower="0.02"', 'lower="low"', "Joint 'grip' has 'low' where a finite number belongs."),
        ('xyz="0 3 4"', 'xyz="0 0 0"', "Joint 'grip' has an axis of zero length."),
    ],
)
def test_bad_numbers_are_refused(tmp_path: Path, old: str, new: str, message: str):
    """One line names the link or the joint."""
    with pytest.raises(UsageError, match=message) as caught:
        plain_urdf(URDF.replace(old, new, 1), ["turn"], tmp_path)
    assert "\n" not in str(caught.value)
