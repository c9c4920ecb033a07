"""MJX: the arm that `mujoco` moves, in double precision, however many arms a call steps."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harness
from tests.plugins.simulators.conftest import FALLEN, PERIOD, home, open_simulator, press
from tests.refusals import refused
from tests.registered import FD100

pytestmark = pytest.mark.usefixtures("installed")


def swing(robot, periods):
    """Each joint to and fro about home, by 0.4 of its unit at most, from rest, (periods, 1, dof)."""
    k = np.arange(periods)[:, None]
    speeds = np.linspace(0.5, 1.5, robot.dof)
    return (robot.home + 0.4 * np.minimum(k / 20.0, 1.0) * np.sin(speeds * PERIOD * k))[:, None]


def largest_difference(robot, periods):
    """Of the tips of both, in one motion [m]."""
    pair, worst = [open_simulator(name, 1, robot) for name in ("mjx", "mujoco")], 0.0
    for target in swing(robot, periods):
        first, second = (simulation.drive(target, PERIOD) for simulation in pair)
        worst = max(worst, float(np.abs(first.end_effector - second.end_effector).max()))
    return worst


def test_tip_is_that_of_mujoco():
    """Over 100 periods in the air both are the same to a nanometre: 4e-16 m was measured, a tenth of a mm is asked."""
    assert largest_difference(FD100, 100) < 1e-9


@pytest.mark.slow
def test_arm_with_meshes_moves_as_in_mujoco():
    """Masses, joints and meshes of an arm that others published are read as `mujoco` reads them."""
    data = pytest.importorskip("pybullet_data")
    assert largest_difference(harness.load_robot(str(Path(data.getDataPath(), "kuka_iiwa/model.urdf"))), 20) < 1e-9


def test_ground_holds_the_arm_up(open_arms):
    """An arm that pushes against the ground rests there, to a tenth of a millimetre where `mujoco` has it."""
    tips = []
    for simulation in (open_arms(1), open_simulator("mujoco", 1)):
        press(simulation)
        for _ in range(20):
            state = simulation.drive(FALLEN, PERIOD)
        assert state.ground_contact[0]
        tips.append(state.end_effector.copy())
    assert_allclose(*tips, atol=1e-4)
    assert tips[0][0, 2] > 0.0


def test_arms_that_one_call_steps_move_as_alone(open_arms):
    """Two at once, mapped, do what each does alone, to rounding; where one is left over, it is stepped twice."""
    poses = home(3) + np.array([[0.0], [0.05], [0.1]])
    together, alone = open_arms(3, at_once=2), open_arms(3)
    for simulation in (together, alone):
        simulation.drive(poses, PERIOD)
        simulation.rest(np.array([False, True, False]))
        simulation.drive(poses + 0.05, PERIOD)
    assert_allclose(together.read().qpos, alone.read().qpos, atol=1e-12)
    assert_allclose(alone.read().qpos[:, 0] - home(3)[:, 0], [0.05, 0.05, 0.15], atol=1e-3)


def test_double_precision_is_its_own(open_arms):
    """What others compute with JAX in this process stays in the precision that they chose."""
    import jax

    assert open_arms(1).drive(home(1) + 1e-9, PERIOD).qpos.dtype == np.float64
    assert jax.numpy.ones(1).dtype == np.float32
    assert not jax.config.jax_enable_x64


def test_shape_that_mjx_does_not_know_is_a_usage_error(open_arms, monkeypatch):
    """One line names the robot, the reason and what to take instead."""
    from mujoco import mjx

    def refuse(_):
        raise NotImplementedError("(plane, cone)\ncollisions not implemented.")

    monkeypatch.setattr(mjx, "put_model", refuse)
    with refused(r"robot 'fd100': \(plane, cone\) collisions .* Take the simulator 'mujoco'"):
        open_arms(1)


def test_importing_it_prints_nothing():
    """MJX says on standard output that Warp is not installed; results are printed there."""
    code = "import harness_plugins.simulators.mjx"
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == ""
