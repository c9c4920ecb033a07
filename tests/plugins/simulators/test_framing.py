"""Every simulator frames an arm as the harness's own picture does: small, large, on a table, a wall and a ceiling."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harness
from harness.robot.robot import read_robot
from harness.scene.picture import camera_for, corners_of, seen_of
from harness.scene.scene import scene_of
from harness.task import ReachTask
from tests.plugins.simulators.conftest import open_simulator

WIDTH, HEIGHT = 160, 120
COLOURED = 60
"""By how much the channels of a marker differ, of 255."""
MOUNTS = {
    "on the ground": ("0 0 0", "0 0 0"),
    "on a table": ("0 0 0.8", "0 0 0"),
    "at a wall": ("0 0 1.5", "0 1.5708 0"),
    "under a ceiling": ("0 0 2.5", "3.14159265 0 0"),
}
ARMS = ["fd100", *(f"{size:g} m {mount}" for size in (0.3, 3.0) for mount in MOUNTS)]


LINK = """<link name="link{k}"><collision><origin xyz="0 0 {half}"/><geometry><box size="{thick} {thick} {length}"/>
  </geometry></collision></link>"""
JOINT = """<joint name="joint{k}" type="revolute"><parent link="{parent}"/><child link="link{k}"/>
  <origin xyz="0 0 {height}"/><axis xyz="{axis}"/><limit lower="-2.5" upper="2.5" velocity="2" effort="9"/></joint>"""
ARM = """<robot name="arm"><link name="room"/><link name="world"/><link name="tip"/>{parts}
  <joint name="mount" type="fixed"><parent link="room"/><child link="world"/><origin xyz="{xyz}" rpy="{rpy}"/></joint>
  <joint name="end" type="fixed"><parent link="link3"/><child link="tip"/><origin xyz="0 0 {length}"/></joint>
</robot>"""


def arm_of(name, folder):
    """FD100, or an arm of so many metres that stands so, at a link `world` that is not the root."""
    if name == "fd100":
        return harness.load_robot(name)
    size, _, mount = name.split(maxsplit=2)
    (xyz, rpy), length = MOUNTS[mount], float(size) / 3.0
    axes = {1: "0 0 1", 2: "0 1 0", 3: "0 1 0"}
    links = [LINK.format(k=k, half=length / 2, thick=length / 5, length=length) for k in axes]
    joints = [
        JOINT.format(
            k=k, parent=f"link{k - 1}" if k > 1 else "world", height=length if k > 1 else length / 3, axis=axis
        )
        for k, axis in axes.items()
    ]
    (folder / "arm.urdf").write_text(ARM.format(parts="".join([*links, *joints]), xyz=xyz, rpy=rpy, length=length))
    return read_robot(folder / "arm.urdf")


@pytest.fixture
def robot(request, tmp_path):
    """The arm that the test names."""
    return arm_of(request.param, tmp_path)


def shares(points, camera):
    """Where points are in the picture, -1 to 1 from edge to edge, (count, 2)."""
    half = np.array([camera.width, camera.height]) / 2
    return np.asarray((camera.project(points)[:, :2] - half) / half)


@pytest.mark.parametrize("robot", ARMS, indirect=True)
@pytest.mark.parametrize("size", [(320, 240), (200, 300)])
def test_the_arm_fills_the_frame_and_stays_within(robot, size):
    """At home it is whole, and not lost: it spans a third of the picture at least; FD100's targets are seen too."""
    camera = camera_for(seen_of(robot), *size)
    arm = shares(corners_of(scene_of(robot), robot.home)[0].reshape(-1, 3), camera)
    assert np.abs(arm).max() < 1.0
    assert np.ptp(arm, axis=0).max() / 2.0 > 1 / 3
    if robot.name == "fd100":
        centre, half = ReachTask().target_box(robot)
        corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        assert np.abs(shares(centre + half * corners, camera)).max() < 1.0


@pytest.mark.parametrize("robot", ["fd100", *ARMS[2::2]], indirect=True)
@pytest.mark.parametrize("simulator", ["mujoco", "dm_control", "pybullet", "kinematic"])
def test_a_marker_is_where_the_camera_projects_it(egl, robot, simulator):
    """Within three pixels: what an engine draws and what the harness computes are the same camera."""
    simulation = open_simulator(simulator, 1, robot)
    simulation.place(robot.home[None])
    camera = camera_for(seen_of(robot), WIDTH, HEIGHT)
    beside = 0.5 * camera.radius * np.array([[-1.0, 1.0, 0.0], [-1.0, 1.0, 1.0], [1.0, 1.0, 1.0]]) / np.sqrt(3.0)
    markers = camera.eye + 0.7 * (camera.centre + beside - camera.eye)  # before the arm
    away = simulation.render(0, camera.centre + 50.0 * camera.radius * camera.axes[0], WIDTH, HEIGHT)
    for marker in markers:
        frame = simulation.render(0, marker, WIDTH, HEIGHT)
        coloured = np.ptp(frame.astype(int), axis=2) > COLOURED  # its shadow is not
        rows, columns = np.nonzero(coloured & (frame != away).any(axis=2))
        assert_allclose(np.array([np.median(columns), np.median(rows)]), camera.project(marker)[:2], atol=3.0)
    simulation.close()


def test_a_small_arm_on_a_high_table_is_not_lost():
    """The world's origin is seen, unless it is far away."""
    arm = np.array([[0.0, 0.0, 0.0], [0.3, 0.0, 0.3]])
    near, far = (camera_for(arm + height * np.eye(3)[2], 320, 240) for height in (0.1, 3.0))
    assert np.abs(shares(np.zeros((1, 3)), near)).max() < 1.0
    assert np.abs(shares(np.zeros((1, 3)), far)).max() > 1.0


@pytest.mark.parametrize("robot", ARMS[1:], indirect=True)
@pytest.mark.parametrize("simulator", ["mujoco", "dm_control", "pybullet"])
def test_a_link_world_may_stand_anywhere(robot, simulator):
    """MuJoCo takes a link of this name for its own world: these arms have one at their mount."""
    simulation = open_simulator(simulator, 1, robot)
    pose = robot.home + 0.1
    assert_allclose(simulation.place(pose[None]).end_effector[0], robot.end_effector(pose), atol=1e-6)
    simulation.close()
