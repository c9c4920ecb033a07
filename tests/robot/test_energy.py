"""Energy of an arm's links: MuJoCo's at any pose and speed, and the work that a motion takes at least."""

import numpy as np
import pytest
from numpy.random import default_rng
from numpy.testing import assert_allclose

import harness
from harness.robot.energy import GRAVITY, energy, least_work, read_bodies
from harness.robot.robot import read_robot
from tests.registered import REGISTRY

SLIDER = """
<robot name="lift">
  <link name="base"/>
  <link name="a"><inertial><origin xyz="0 0 0.1" rpy="0.3 0 0"/><mass value="2"/>
    <inertia ixx="0.02" iyy="0.03" izz="0.04" ixy="0.001" ixz="0" iyz="0.002"/></inertial></link>
  <link name="b"><inertial><mass value="3"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <link name="c"/>
  <link name="load"><inertial><origin xyz="0.1 0 0" rpy="0 0 0.5"/><mass value="1"/>
    <inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="one" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
  <joint name="two" type="prismatic"><parent link="a"/><child link="b"/><origin xyz="0 0 0.4" rpy="0.2 0.1 0"/>
    <axis xyz="0 0 1"/><limit lower="0" upper="0.5" velocity="1" effort="1"/></joint>
  <joint name="three" type="revolute"><parent link="b"/><child link="c"/><origin xyz="0 0 0.3"/><axis xyz="1 1 0"/>
    <limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
  <joint name="weld" type="fixed"><parent link="c"/><child link="load"/><origin xyz="0 0 0.2" rpy="0.4 0 0.1"/></joint>
</robot>
"""


@pytest.fixture(scope="module")
def slider(tmp_path_factory):
    """An arm with a joint that slides, and a load that is fixed to a link without mass."""
    path = tmp_path_factory.mktemp("lift") / "lift.urdf"
    path.write_text(SLIDER)
    return read_robot(path)


@pytest.mark.parametrize("name", ["fd100", "unity-arm", "slider"])
def test_energy_is_that_of_mujoco(name, request):
    """At random poses and speeds; the base, which does not move, has no part in it."""
    mujoco = pytest.importorskip("mujoco")
    robot = request.getfixturevalue("slider") if name == "slider" else harness.load_robot(name, REGISTRY)
    from harness_plugins.mujoco_model.model import build_model

    model = build_model(robot, 0.01, 10.0)
    model.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    data, rng = mujoco.MjData(model), default_rng(0)
    qpos = rng.uniform(robot.lower, robot.upper, (20, robot.dof))
    qvel = rng.uniform(-2.0, 2.0, (20, robot.dof))
    expected = []
    for data.qpos[:], data.qvel[:] in zip(qpos, qvel, strict=True):
        mujoco.mj_forward(model, data)
        expected.append(data.energy.copy())
    potential, kinetic = np.array(expected).T
    bodies = read_bodies(robot)
    at_rest = energy(robot.chain, bodies, qpos, 0.0 * qvel)
    assert_allclose(np.diff(at_rest), np.diff(potential), atol=1e-9)
    assert_allclose(energy(robot.chain, bodies, qpos, qvel) - at_rest, kinetic, rtol=1e-8)


def test_any_leading_shape(slider):
    """A batch of batches has the energies of its rows."""
    qpos, qvel = default_rng(1).uniform(0.0, 0.5, (2, 4, 5, 3))
    bodies = read_bodies(slider)
    whole = energy(slider.chain, bodies, qpos, qvel)
    assert whole.shape == (4, 5)
    assert whole[2, 3] == pytest.approx(energy(slider.chain, bodies, qpos[2, 3], qvel[2, 3]))


def test_work_of_a_lift(slider):
    """Slowly up and down, the arm upright: the weight of what slides, times the way up; the way down gives nothing."""
    up = np.zeros((1001, 3))
    up[:, 1] = np.linspace(0.0, 0.4, 1001)
    there_and_back = np.concatenate([up, up[::-1]])
    height = 0.4 * np.cos(0.2) * np.cos(0.1)
    slow = least_work(slider.chain, read_bodies(slider), there_and_back, 10.0)
    assert slow == pytest.approx(4.0 * GRAVITY * height, rel=1e-4)


def test_work_of_a_start(slider):
    """Along the level the kinetic energy is all; whoever stands still does none."""
    turned = np.zeros((2, 3))
    turned[1, 1] = 0.1
    bodies = read_bodies(slider)
    gain = energy(slider.chain, bodies, turned[1], np.array([0.0, 2.0, 0.0])) - energy(
        slider.chain, bodies, turned[0], np.zeros(3)
    )
    assert least_work(slider.chain, bodies, turned, 0.05) == pytest.approx(gain)
    assert least_work(slider.chain, bodies, np.zeros((5, 3)), 0.05) == 0.0


@pytest.mark.parametrize("rows", [0, 1])
def test_no_motion_takes_no_work(slider, rows):
    """An episode without a step."""
    assert least_work(slider.chain, read_bodies(slider), np.zeros((rows, 3)), 0.1) == 0.0


def test_arm_without_mass_has_no_bodies(tmp_path_factory):
    """Its URDF says nothing of masses: none are made up."""
    import re

    path = tmp_path_factory.mktemp("ghost") / "ghost.urdf"
    path.write_text(re.sub(r"<inertial>.*?</inertial>", "", SLIDER, flags=re.DOTALL))
    assert read_bodies(read_robot(path)) is None
