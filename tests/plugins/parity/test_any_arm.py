"""Every arm that can be run can be measured: low, sunk, bare, sliding, heavy, tiny, at a wall and under a ceiling."""

import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from harness.robot import build_solids, link_frames
from harness.robot.robot import read_robot
from harness_plugins.parity import Setting, choose_contenders, compare_simulators
from harness_plugins.parity.motions import GroundClearance
from harness_plugins.parity.orders import draw_orders
from tests.registered import REGISTRY

SETTING = {"steps": 30, "episodes": 2}
SHALLOW = 0.01
"""A dive goes at least so deep where an arm gets there, [m]."""
ALL = {"slow", "smooth", "fast", "singular", "contact"}


class Part(NamedTuple):
    """A joint and the link that it moves; a box along z begins where the joint is."""

    axis: str
    length: float
    at: str = "0 0 0"
    kind: str = "revolute"
    range: tuple[float, float] = (-2.5, 2.5)
    mass: float = 1.0
    solid: bool = True
    offset: float = 0.0
    """How far up the link's box is moved, [m]."""


LINK = """<link name="link{k}">{solid}<inertial><origin xyz="0 0 {half}"/><mass value="{mass}"/>
  <inertia ixx="{inertia}" iyy="{inertia}" izz="{inertia}" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
SOLID = """<collision><origin xyz="0 0 {middle}"/><geometry><box size="{thick} {thick} {length}"/></geometry>
  </collision>"""
JOINT = """<joint name="joint{k}" type="{kind}"><parent link="link{before}"/><child link="link{k}"/><origin xyz="{at}"/>
  <axis xyz="{axis}"/><limit lower="{low}" upper="{high}" velocity="2" effort="50"/></joint>"""
MOUNT = """<link name="room"/><link name="link0"/><joint name="mount" type="fixed"><parent link="room"/>
  <child link="link0"/><origin xyz="{}" rpy="{}"/></joint>"""
END = """<link name="tip"/><joint name="end" type="fixed"><parent link="link{k}"/><child link="tip"/>
  <origin xyz="0 0 {length}"/></joint>"""


def arm_of(folder, parts, xyz="0 0 0", rpy="0 0 0", home=None):
    """An arm of these parts, read from its file."""
    text = MOUNT.format(xyz, rpy)
    for k, part in enumerate(parts, 1):
        thick = part.length / 6.0
        solid = SOLID.format(middle=part.length / 2.0 + part.offset, thick=thick, length=part.length)
        inertia = part.mass * part.length**2 / 12.0
        said = {"mass": part.mass, "inertia": inertia, "half": part.length / 2.0}
        text += LINK.format(k=k, solid=solid if part.solid else "", **said)
        low, high = part.range
        text += JOINT.format(k=k, before=k - 1, kind=part.kind, at=part.at, axis=part.axis, low=low, high=high)
    text += END.format(k=len(parts), length=parts[-1].length)
    (folder / "arm.urdf").write_text(f'<robot name="arm">{text}</robot>')
    if home is not None:
        (folder / "robot.toml").write_text(f'urdf = "arm.urdf"\nhome_deg = {home}\n')
    return read_robot(folder / "arm.urdf")


def elbows(solid=True, at="0 0 0.3", scale=1.0, last_mass=1.0):
    """Two links that bend up and down."""
    return [
        Part("0 1 0", 0.4 * scale, at, solid=solid, mass=scale**3),
        Part("0 1 0", 0.4 * scale, f"0 0 {0.4 * scale}", solid=solid, mass=last_mass * scale**3),
    ]


TURN = Part("0 0 1", 0.3, "0 0 0.05")
ARMS = {
    "a low turret": {"parts": [Part("0 0 1", 0.02, "0 0 0.005"), *elbows(at="0 0 0.03")]},
    "no solids": {"parts": [TURN._replace(solid=False), *elbows(solid=False)]},
    "a foot in the ground": {"parts": [Part("0 0 1", 0.3, "0 0 0.05", offset=-0.1), *elbows()], "home": [0, 30, 60]},
    "a long slide": {"parts": [Part("1 0 0", 0.3, "0 0 0.05", "prismatic", (0.0, 5.0)), *elbows()]},
    "a heavy last link": {"parts": [TURN, *elbows(last_mass=60.0)]},
    "a few grams": {"parts": [Part("0 0 1", 0.08, "0 0 0.02", mass=0.02), *elbows(at="0 0 0.08", scale=0.2)]},
    "at a wall": {"parts": [TURN, *elbows()], "xyz": "0 0 0.7", "rpy": "0 1.5708 0"},
    "at the foot of a wall": {"parts": [TURN, *elbows()], "xyz": "0 0 0.06", "rpy": "0 1.5708 0"},
    "under a ceiling": {"parts": [TURN, *elbows()], "xyz": "0 0 1", "rpy": "3.14159265 0 0"},
    "far under a ceiling": {"parts": [TURN, *elbows()], "xyz": "0 0 3", "rpy": "3.14159265 0 0"},
    "always low": {
        "parts": [TURN, elbows()[0]._replace(range=(1.93, 1.97)), elbows()[1]._replace(range=(-0.02, 0.02))],
        "home": [0, 111.7, 0],
    },
    "on its belly": {"parts": [TURN, *elbows()], "home": [0, 110, 0]},
}
LEFT_OUT = {"far under a ceiling": {"contact"}, "always low": {"contact"}}
"""What such an arm cannot do at all."""
TOUCHES = {"a foot in the ground"}
"""Arms that engines push out of the ground all the time, each in its own way."""


@pytest.fixture(params=ARMS)
def named(request, tmp_path):
    """A name and its arm."""
    return request.param, arm_of(tmp_path, **ARMS[request.param])


def test_no_arm_is_refused(named, printed):
    """All classes are measured in all engines, but what an arm cannot do at all, which is told; the arms do move."""
    name, robot = named
    contenders = choose_contenders(REGISTRY, ["kinematic", "mujoco", "pybullet"], None)
    found = compare_simulators(contenders, Setting(robot, **SETTING))
    assert not found.failed
    assert set(found.told) == ALL - LEFT_OUT.get(name, set())
    assert set(found.left_out) == LEFT_OUT.get(name, set())
    assert all(reason in printed(found) for reason in found.left_out.values())
    for simulator in found.simulators:
        assert simulator.placement.error_m < 1e-6
        assert not simulator.missing
    for pair in found.pairs:
        assert name in TOUCHES or pair.differences["slow"].max_tip_error_m < 5e-3
    for motion in draw_orders(Setting(robot, **SETTING)).classes.values():
        assert np.ptp(motion, axis=0).max() > 0.01


@pytest.mark.parametrize("named", ["always low"], indirect=True)
def test_an_arm_that_lies_low_is_moved_by_its_solids(named, printed):
    """No motion keeps a tenth of the reach; what stands above the ground at home stays above it, and it is told."""
    _, robot = named
    orders = draw_orders(Setting(robot, **SETTING))
    assert orders.held["slow"] == "solids"
    slow = orders.classes["slow"].reshape(-1, robot.dof)
    assert GroundClearance(robot, "solids").is_clear(slow).all()
    assert not GroundClearance(robot).is_clear(slow).all()
    found = compare_simulators(choose_contenders(REGISTRY, ["kinematic", "mujoco"], None), Setting(robot, **SETTING))
    assert "Near the ground: " in printed(found)
    assert found.to_json()["near_ground"]["slow"] == "solids"


def test_an_arm_below_the_ground_is_moved_all_the_same(tmp_path):
    """Where nothing can keep above it, nothing has to; engines then differ, and this is told."""
    robot = arm_of(tmp_path, [TURN, *elbows(solid=False)], xyz="0 0 -3", home=[0, 0, 0])
    assert draw_orders(Setting(robot, **SETTING)).held["slow"] == "solids"


@pytest.mark.parametrize("named", ["a foot in the ground"], indirect=True)
def test_a_dive_is_one_of_what_stands_above_the_ground(named):
    """The foot is in it all the time: the arm dives with another part, which is above it at the start."""
    _, robot = named
    dives = draw_orders(Setting(robot, **SETTING)).dives
    heights = GroundClearance(robot, "solids")._heights(dives[:, 0])[1:]
    assert (heights[:, 0] > 0.0).all()
    assert heights[:, -1].min() < -SHALLOW / 2


def test_a_dive_goes_as_deep_as_an_arm_can(tmp_path):
    """This one hangs from above and gets 3 cm into the ground at most; one that hangs higher has no dives."""
    parts = [TURN, *elbows()]
    low, high = (arm_of(tmp_path, parts, xyz=f"0 0 {z}", rpy="3.14159265 0 0") for z in (1.12, 1.3))
    frames = link_frames(low.chain, draw_orders(Setting(low, **SETTING)).dives[-1])
    assert (build_solids(low.joint_shapes).lowest(frames) < -SHALLOW).all()
    assert draw_orders(Setting(high, **SETTING)).dives is None


SHARE = "cmeel.prefix/share"
PUBLIC = {
    "ur5": f"{SHARE}/example-robot-data/robots/ur_description/urdf/ur5_robot.urdf",
    "ur10": f"{SHARE}/example-robot-data/robots/ur_description/urdf/ur10_robot.urdf",
    "so101": f"{SHARE}/example-robot-data/robots/so_arm_description/urdf/so101.urdf",
    "kr16": "rtbdata/xacro/kuka_description/kuka_kr16/urdf/kr16_2.urdf",
    "kr120": "rtbdata/xacro/kuka_description/kuka_kr120/urdf/kr120r2500pro.urdf",
    "iiwa7": "tesseract_robotics/data/tesseract/support/urdf/iiwa7.urdf",
}


@pytest.mark.slow
@pytest.mark.parametrize("name", PUBLIC)
def test_public_arms_are_measured(name):
    """In every class and engine, within a centimetre where they move smoothly."""
    found = [path for path in (Path(place, PUBLIC[name]) for place in sys.path) if path.is_file()]
    if not found:
        pytest.skip(f"no installed package has {PUBLIC[name]}")
    robot = read_robot(found[0])
    contenders = choose_contenders(REGISTRY, ["kinematic", "mujoco", "pybullet"], None)
    parity = compare_simulators(contenders, Setting(robot, steps=60, episodes=2))
    assert not parity.failed
    assert set(parity.told) == ALL
    assert max(pair.differences["smooth"].max_tip_error_m for pair in parity.pairs) < 0.01
    assert all(simulator.placement.error_m < 1e-6 for simulator in parity.simulators)
