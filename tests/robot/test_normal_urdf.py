"""The URDF that simulators read: nothing in it is left to guess."""

from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
import pytest

from harness.errors import UsageError
from harness.robot.kinematics import build_chain, forward
from harness.robot.normal_urdf import normal_urdf
from harness.robot.urdf import Urdf, parse_urdf, read_chain

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


def normal(text: str, folder: Path) -> Urdf:
    """The URDF of an arm of which one joint is driven."""
    return normal_urdf(parse_urdf(text), ["turn"], folder)


def finger_pose(urdf: Urdf, *qpos: float) -> np.ndarray:
    """T_base_finger, (4, 4)."""
    return forward(build_chain(read_chain(urdf, "finger")), qpos)


def _parts(urdf: Urdf) -> dict[str, Element]:
    """Links and joints by their names."""
    return {part.get("name", ""): part for part in urdf.element}


def _moments(link: Element) -> list[float]:
    inertia = link.find("inertial/inertia")
    return [float(inertia.get(name)) for name in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")]


def test_plain_text_stays_as_it_is(tmp_path: Path):
    """Where there is nothing to do, the text is the same to the last blank."""
    given = parse_urdf(FIXED)
    assert normal_urdf(given, ["turn"], tmp_path) is given
    assert given.text is FIXED


def test_text_is_that_of_the_element(tmp_path: Path):
    """What engines read says what the harness reads, and the URDF that was given is left as it was."""
    given = parse_urdf(URDF.replace(BODY, ""))
    before = ElementTree.tostring(given.element)
    plain = normal_urdf(given, ["turn"], tmp_path)
    assert ElementTree.tostring(ElementTree.fromstring(plain.text)) == ElementTree.tostring(plain.element) != before
    assert ElementTree.tostring(given.element) == before


def test_other_joints_are_fixed_where_they_are_nearest_to_zero(
    tmp_path_factory: pytest.TempPathFactory, subtests: pytest.Subtests
):
    """What the joint carries is, in the fixed one, exactly where it was at that position."""
    rows = [
        ("prismatic", (0.02, 0.05), 0.02),
        ("prismatic", (-0.05, -0.01), -0.01),
        ("prismatic", (-1.0, 1.0), 0.0),
        ("revolute", (0.7, 1.5), 0.7),
        ("revolute", (-3.0, 1.5), 0.0),
        ("continuous", (0.5, 0.7), 0.0),
    ]
    for kind, limits, position in rows:
        with subtests.test(kind=kind, limits=limits, position=position):
            tmp_path = tmp_path_factory.mktemp("case")
            given = 'lower="{}" upper="{}"'.format(*limits)
            urdf = URDF.replace('"prismatic"', f'"{kind}"').replace('lower="0.02" upper="0.05"', given)
            plain = normal(urdf, tmp_path)
            grip = _parts(plain)["grip"]
            assert grip.get("type") == "fixed"
            assert {part.tag for part in grip} == {"parent", "child", "origin"}
            before = finger_pose(parse_urdf(urdf), 0.3, position)
            np.testing.assert_allclose(finger_pose(plain, 0.3), before, atol=1e-15)


@pytest.mark.parametrize("kind", ["floating", "planar"])
def test_joints_with_several_ways_to_move_are_fixed_at_zero(tmp_path: Path, kind: str):
    """Beside the chain they may be, and stand still."""
    plain = normal(URDF.replace('"prismatic"', f'"{kind}"'), tmp_path)
    assert read_chain(plain, "finger")[1].xyz == (0.1, 0.2, 0.3)


def test_joint_that_mimics_is_fixed(tmp_path: Path):
    """A finger that follows another one stands still as that one does, its limits missing or not."""
    urdf = URDF.replace('<dynamics damping="1"/>', '<mimic joint="turn"/>')
    assert _parts(normal(urdf, tmp_path))["grip"].find("mimic") is None


def test_turned_up_by_a_right_angle(tmp_path: Path):
    """At a pitch of 90 degrees, where roll and yaw are one, the fixed joint still has the same pose."""
    urdf = URDF.replace('rpy="0.4 0.5 0.6"', f'rpy="0.4 {np.pi / 2} 0.6"')
    plain = normal(urdf, tmp_path)
    before = finger_pose(parse_urdf(urdf), 0.0, 0.02)
    np.testing.assert_allclose(finger_pose(plain, 0.0), before, atol=1e-15)


@pytest.mark.parametrize(
    "body", ["", "<inertial/>", '<inertial><mass value="1"/></inertial>', BODY.replace('value="1"', 'value="0"')]
)
def test_link_without_mass_gets_next_to_none(tmp_path: Path, body: str):
    """No engine is left to take 1 kg, a solid of water, or a part of the ground."""
    finger = _parts(normal(FIXED.replace(f'"finger">{BODY}', f'"finger">{body}'), tmp_path))["finger"]
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
    assert _moments(_parts(normal(urdf, tmp_path))["finger"]) == pytest.approx(expected)


def test_meshes_have_full_paths(tmp_path: Path):
    """Of what collides and of what is seen, as they lie beside the URDF; scale and the rest stay."""
    (tmp_path / "a.stl").touch()
    shape = '<{0}><geometry><mesh filename="a.stl" scale="1 2 3"/></geometry></{0}>'
    urdf = FIXED.replace(f'"arm">{BODY}', f'"arm">{BODY}{shape.format("visual")}{shape.format("collision")}')
    meshes = list(normal(urdf, tmp_path).element.iter("mesh"))
    assert [dict(mesh.attrib) for mesh in meshes] == [{"filename": str(tmp_path / "a.stl"), "scale": "1 2 3"}] * 2


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('mass value="1"', 'mass value="heavy"', "Link 'base' has 'heavy' in <mass value=...>. Give a finite number."),
        ('ixx="1"', 'ixx="nan"', "Link 'base' has 'nan' in <inertia ixx=...>. Give a finite number."),
        ('xyz="0 3 4"', 'xyz="0 0 0"', "Joint 'grip' has an axis of zero length."),
    ],
)
def test_bad_numbers_are_refused(tmp_path: Path, old: str, new: str, message: str):
    """One line names the link or the joint."""
    with pytest.raises(UsageError, match=message) as caught:
        normal(URDF.replace(old, new, 1), tmp_path)
    assert "\n" not in str(caught.value)
