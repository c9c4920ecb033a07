"""The URDF that simulators read: nothing in it is left to guess."""

import sys
from xml.etree import ElementTree

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harness import load_robot
from harness.robot import forward, parse_urdf
from harness.robot.kinematics import build_chain
from harness.robot.normal_urdf import named, normal_urdf
from harness.robot.shapes import read_shapes
from harness.robot.urdf import read_chain
from tests.refusals import refused
from tests.robot.test_meshes import CORNERS, binary_stl, collada

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


def normal(text, folder):
    """The URDF of an arm of which one joint is driven."""
    return normal_urdf(parse_urdf(text), ["turn"], folder).urdf


def finger_pose(urdf, *qpos):
    """T_base_finger, (4, 4)."""
    return forward(build_chain(read_chain(urdf, "finger")), qpos)


def _parts(urdf):
    """Links and joints by their names."""
    return {part.get("name", ""): part for part in urdf.element}


def _moments(link):
    inertia = link.find("inertial/inertia")
    return [float(inertia.get(name)) for name in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")]


def test_plain_text_stays_as_it_is(tmp_path):
    """Where there is nothing to do, the text is the same to the last blank."""
    given = parse_urdf(FIXED)
    plain, warnings = normal_urdf(given, ["turn"], tmp_path)
    assert plain is given
    assert warnings == ()
    assert given.text is FIXED


def test_text_is_that_of_the_element(tmp_path):
    """What engines read says what the harness reads, and the URDF that was given is left as it was."""
    given = parse_urdf(URDF.replace(BODY, ""))
    before = ElementTree.tostring(given.element)
    plain, _ = normal_urdf(given, ["turn"], tmp_path)
    assert ElementTree.tostring(ElementTree.fromstring(plain.text)) == ElementTree.tostring(plain.element) != before
    assert ElementTree.tostring(given.element) == before


def test_other_joints_are_fixed_where_they_are_nearest_to_zero(tmp_path_factory, subtests):
    """What the joint carries is, in the fixed one, exactly where it was at that position."""
    for kind, limits, position in [
        ("prismatic", (0.02, 0.05), 0.02),
        ("prismatic", (-0.05, -0.01), -0.01),
        ("prismatic", (-1.0, 1.0), 0.0),
        ("revolute", (0.7, 1.5), 0.7),
        ("revolute", (-3.0, 1.5), 0.0),
        ("continuous", (0.5, 0.7), 0.0),
    ]:
        with subtests.test(kind=kind, limits=limits, position=position):
            tmp_path = tmp_path_factory.mktemp("case")
            given = 'lower="{}" upper="{}"'.format(*limits)
            urdf = URDF.replace('"prismatic"', f'"{kind}"').replace('lower="0.02" upper="0.05"', given)
            plain = normal(urdf, tmp_path)
            grip = _parts(plain)["grip"]
            assert grip.get("type") == "fixed"
            assert {part.tag for part in grip} == {"parent", "child", "origin"}
            before = finger_pose(parse_urdf(urdf), 0.3, position)
            assert_allclose(finger_pose(plain, 0.3), before, atol=1e-15)


@pytest.mark.parametrize("kind", ["floating", "planar"])
def test_joints_with_several_ways_to_move_are_fixed_at_zero(tmp_path, kind):
    """Beside the chain they may be, and stand still."""
    assert read_chain(normal(URDF.replace('"prismatic"', f'"{kind}"'), tmp_path), "finger")[1].xyz == (0.1, 0.2, 0.3)


def test_joint_that_mimics_is_fixed(tmp_path):
    """A finger that follows another one stands still as that one does, its limits missing or not."""
    urdf = URDF.replace('<dynamics damping="1"/>', '<mimic joint="turn"/>')
    assert _parts(normal(urdf, tmp_path))["grip"].find("mimic") is None


def test_turned_up_by_a_right_angle(tmp_path):
    """At a pitch of 90 degrees, where roll and yaw are one, the fixed joint still has the same pose."""
    urdf = URDF.replace('rpy="0.4 0.5 0.6"', f'rpy="0.4 {np.pi / 2} 0.6"')
    plain = normal(urdf, tmp_path)
    before = finger_pose(parse_urdf(urdf), 0.0, 0.02)
    assert_allclose(finger_pose(plain, 0.0), before, atol=1e-15)


@pytest.mark.parametrize(
    "body", ["", "<inertial/>", '<inertial><mass value="1"/></inertial>', BODY.replace('value="1"', 'value="0"')]
)
def test_link_without_mass_gets_next_to_none(tmp_path, body):
    """No engine is left to take 1 kg, a solid of water, or a part of the ground."""
    finger = _parts(normal(FIXED.replace(f'"finger">{BODY}', f'"finger">{body}'), tmp_path))["finger"]
    assert [part.tag for part in finger] == ["inertial"]
    assert float(finger.find("inertial/mass").get("value")) == 1e-6


@pytest.mark.parametrize(
    ("moments", "expected"),
    [
        ('ixx="1" iyy="2" izz="6"', [3.0, 3.0, 3.0, 0.0, 0.0, 0.0]),
        ('ixx="0" iyy="0" izz="0"', [1e-9, 1e-9, 1e-9, 0.0, 0.0, 0.0]),
        ('ixx="3e-7" iyy="3e-7" izz="1e-15"', [2e-7, 2e-7, 2e-7, 0.0, 0.0, 0.0]),
        ('ixx="-1" iyy="2" izz="2"', [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]),
        ('ixx="1" iyy="2" izz="3"', [1.0, 2.0, 3.0, 0.0, 0.0, 0.0]),
    ],
)
def test_inertia_that_no_body_has_becomes_a_balls(tmp_path, moments, expected):
    """One engine would refuse it, another set it to zero; the mean stays. What a flat plate has stays as it is."""
    urdf = FIXED.replace('"finger">' + BODY, '"finger">' + BODY.replace('ixx="1" iyy="2" izz="3"', moments))
    assert _moments(_parts(normal(urdf, tmp_path))["finger"]) == pytest.approx(expected)


def test_meshes_have_full_paths(tmp_path):
    """Of what collides and of what is seen, as they lie beside the URDF; scale and the rest stay."""
    (tmp_path / "a.stl").write_bytes(binary_stl(CORNERS))
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
def test_bad_numbers_are_refused(tmp_path, old, new, message):
    """One line names the link or the joint."""
    with refused(message):
        normal(URDF.replace(old, new, 1), tmp_path)


MESH = '<{part}><geometry><mesh filename="{file}"/></geometry></{part}>'


def with_mesh(folder, file, part="visual", link="arm", more=""):
    """The arm with a mesh in one of its links."""
    (folder / "good.stl").write_bytes(binary_stl(CORNERS))
    (folder / "good.dae").write_text(collada(CORNERS))
    (folder / "bad.glb").write_bytes(b"glTF")
    (folder / "none.stl").write_bytes(binary_stl(CORNERS[:0]))
    (folder / "points.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n")
    (folder / "line.obj").write_text("v 0 0 0\nv 1 0 0\nv 2 0 0\nv 3 0 0\nf 1 2 3\n")
    (folder / "one.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    with (folder / "large.stl").open("wb") as sparse:
        sparse.truncate(2**30)
    shape = MESH.format(part=part, file=file)
    return normal_urdf(parse_urdf(FIXED.replace(f'"{link}">{BODY}', f'"{link}">{BODY}{shape}{more}')), ["turn"], folder)


def test_drawing_that_can_be_read_stays(tmp_path):
    """And nothing is told; the counter-example of those that are left out."""
    for file in ("good.stl", "good.dae"):
        urdf, warnings = with_mesh(tmp_path, file)
        assert urdf.element.find("link/visual/geometry/mesh").get("filename") == str(tmp_path / file)
        assert warnings == ()


def test_drawing_that_cannot_be_read_is_left_out(tmp_path, subtests):
    """No simulator sees it; one line says which link had it, and why. What collides stays."""
    rows = [
        ("away.stl", "has the mesh 'away.stl', and there is no file"),
        ("away.dae", "has the mesh 'away.dae', and there is no file"),
        ("bad.glb", "bad.glb' cannot be read as a mesh"),
        ("none.stl", "none.stl' cannot be read as a mesh"),
        ("points.obj", "points.obj', which has no surface"),
        ("line.obj", "line.obj', which has no surface"),
        ("one.obj", "one.obj', which has no surface"),
        ("large.stl", "1,073,741,824 bytes, 67,108,864 are allowed"),
        ('good.stl" scale="1 0 1', "'1 0 1' in <mesh scale=...>"),
        ("http://host/a.stl", "allowed are paths, package://"),
    ]
    ball = "<collision><geometry><sphere radius='0.1'/></geometry></collision>"
    for file, reason in rows:
        with subtests.test(file=file):
            urdf, (line,) = with_mesh(tmp_path, file, more=ball)
            assert urdf.element.find("link/visual") is None
            assert urdf.element.find("link/collision/geometry/sphere") is not None
            assert urdf.text == ElementTree.tostring(urdf.element, encoding="unicode")
            assert line.startswith("1 drawing is left out: Link 'arm' has ")
            assert reason in line
            assert "\n" not in line


def test_drawings_are_left_out_in_one_line(tmp_path, monkeypatch):
    """Those whose reader is not installed, with the command that installs it; and the first of the others."""
    monkeypatch.setitem(sys.modules, "trimesh", None)
    more = "".join(MESH.format(part="visual", file=file) for file in ("bad.glb", "good.dae", "away.stl", "away.obj"))
    urdf, (line,) = with_mesh(tmp_path, "good.dae", more=more)
    assert urdf.element.find("link/visual") is None
    assert line.startswith(
        "5 drawings are left out: .dae, .glb (pip install 'fd100-harness[meshes]' has them read); "
        "Link 'arm' has the mesh 'away.stl', and there is no file"
    )
    assert line.endswith(" 1 more cannot be read.")


@pytest.mark.parametrize("file", ["away.stl", "bad.glb", "none.stl"])
def test_collision_mesh_that_stands_still_is_left_out(tmp_path, file):
    """It can hit nothing that the arm does not reach for; the same of a link that moves is an error."""
    urdf, (line,) = with_mesh(tmp_path, file, "collision", "base")
    assert urdf.element.find("link/collision") is None
    assert line.startswith("link 'base' without collision meshes, which no joint of the chain moves: Link 'base' has ")
    with refused("Link 'finger' has "):
        read_shapes(with_mesh(tmp_path, file, "collision", "finger").urdf)


def test_collision_mesh_that_moves_says_what_reads_it(tmp_path, monkeypatch):
    """A COLLADA file without its reader: as a part of the arm refused, off the arm left out."""
    assert len(read_shapes(with_mesh(tmp_path, "good.dae", "collision").urdf)["arm"][0].points) == 4
    monkeypatch.setitem(sys.modules, "collada", None)
    with refused(r"Link 'arm' has a collision mesh: .* pip install 'fd100-harness\[meshes\]'"):
        read_shapes(with_mesh(tmp_path, "good.dae", "collision").urdf)
    _, (line,) = with_mesh(tmp_path, "good.dae", "collision", "base")
    assert "pip install 'fd100-harness[meshes]'" in line


BALL = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'


def told_of(folder, *bodies):
    """What is told of the arm with other parts in some of its links."""
    text = FIXED
    for link, body in bodies:
        text = text.replace(f'"{link}">{BODY}', f'"{link}">{body}')
    return normal_urdf(parse_urdf(text), ["turn"], folder).warnings


def test_links_without_mass_are_told(tmp_path):
    """Where nothing that moves with them has a mass, and they have a shape: elsewhere it changes nothing."""
    line = "links 'arm', 'finger' without mass or inertia: 1e-6 kg is taken. Give each its <inertial>"
    assert told_of(tmp_path, ("arm", BALL), ("finger", BALL)) == (line,)
    assert told_of(tmp_path, ("arm", BALL), ("finger", "")) == (line.replace("links 'arm', 'finger'", "link 'arm'"),)
    assert told_of(tmp_path, ("arm", ""), ("finger", "")) == ()
    assert told_of(tmp_path, ("arm", BALL)) == ()
    assert told_of(tmp_path, ("base", BALL)) == ()


def test_impossible_inertia_is_told_with_its_rule(tmp_path):
    """Of links that move and have a mass; which becomes a ball's is seen above."""
    negative, long = (BODY.replace('ixx="1" iyy="2" izz="3"', each) for each in ('ixx="-1"', 'ixx="1" iyy="1" izz="3"'))
    assert told_of(tmp_path, ("arm", negative), ("finger", long)) == (
        "an inertia that no body has: link 'arm' with a principal moment of 0 or less; link 'finger' with one larger "
        "than the two others together. A ball's with the same mean is taken",
    )
    assert told_of(tmp_path, ("base", negative)) == ()
    assert told_of(tmp_path, ("arm", negative.replace('value="1"', 'value="1e-9"'))) == ()
    nothing = BODY.replace('ixx="1" iyy="2" izz="3"', 'ixx="0" iyy="0" izz="0"')
    assert told_of(tmp_path, ("arm", nothing)) == ()  # what is fixed to it has enough
    (line,) = told_of(tmp_path, ("arm", nothing), ("finger", ""))
    assert line.startswith("an inertia that no body has: link 'arm' with a principal moment of 0 or less.")


def test_many_links_are_counted():
    """Three of them are named."""
    assert named(["a", "b"]) == "links 'a', 'b'"
    assert named(list("abcde")) == "links 'a', 'b', 'c' and 2 more"


def test_first_inertial_counts(tmp_path):
    """As in ROS; MuJoCo refuses a second one."""
    (arm,) = normal(FIXED.replace(f'"arm">{BODY}', f'"arm">{BODY}<inertial/>'), tmp_path).element.iterfind(
        "link[@name='arm']"
    )
    assert len(arm.findall("inertial")) == 1
    assert float(arm.find("inertial/mass").get("value")) == 1.0


@pytest.mark.parametrize("name", ["fd100", "unity-arm"])
def test_packaged_arms_have_no_warnings(name):
    """Nothing in them is changed."""
    assert load_robot(name).warnings == ()
