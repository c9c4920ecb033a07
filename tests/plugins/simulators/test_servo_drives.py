"""MuJoCo's drives with limits, links that collide with one another, and ideal drives as they were."""

import json
from pathlib import Path

import mujoco
import numpy as np
import pytest
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

import harness
from harness.robot.robot import read_robot
from harness.simulator import ServoTrack, State
from harness_plugins.kit import CHECKS
from harness_plugins.kit.contract import violations
from harness_plugins.mujoco_model import build_model
from harness_plugins.simulators.dm_control import DmControl
from harness_plugins.simulators.mujoco import Mujoco
from tests.plugins.simulators.conftest import PERIOD, REGISTRY, ROBOT
from tests.plugins.simulators.test_servo_engines import with_drives

STEP = 0.005
BEFORE = json.loads((Path(__file__).parent / "ideal_drives.json").read_text())
"""States that were recorded before there were other drives."""
EXACT = ("sim-tracking", "sim-velocity", "sim-partial-durations", "sim-small-moves")
"""Checks of ideal drives."""


def _swing(num_envs, period):
    """Joint targets of a quick motion, (num_envs, dof)."""
    return ROBOT.home + 0.4 * np.sin(0.15 * (period + 1) + np.arange(num_envs)[:, None] + np.arange(6))


def _swung(simulator, num_envs, periods, robot=ROBOT):
    """States of that motion from home."""
    simulation = simulator.open(robot, num_envs, PERIOD)
    simulation.reset(np.tile(ROBOT.home, (num_envs, 1)), np.ones(num_envs, bool))
    states = []
    for period in range(periods):
        states.append(State._make(np.array(array) for array in simulation.drive(_swing(num_envs, period), PERIOD)))
    simulation.close()
    return states


@pytest.mark.parametrize("run", BEFORE)
def test_ideal_drives_move_as_before(run):
    """Thirty periods end where they ended before there was a field `drive`; another machine may differ a little."""
    name, num_envs = run.split()
    last = _swung(REGISTRY.get("simulators", name).load()(), int(num_envs), 30)[-1]
    for field, numbers in BEFORE[run].items():
        assert_allclose(getattr(last, field), numbers, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("weak", [1.0, 0.5])
def test_torques_are_those_of_the_law(weak):
    """MuJoCo's actuators move an arm as `Servo.torque` does that is computed here, physics step by physics step."""
    robot = with_drives(max_torque=weak * ROBOT.servo.max_torque)
    states = _swung(Mujoco(drive="servo"), 1, 10, robot)
    model = build_model(robot, STEP, 100.0, robot.servo)
    model.actuator_gainprm[:] = model.actuator_biasprm[:] = model.body_gravcomp[:] = 0.0
    data, other, track = mujoco.MjData(model), mujoco.MjData(model), ServoTrack(robot.servo, 1, STEP)
    data.qpos = robot.home
    track.reset(robot.home[None], np.ones(1, bool))
    saturated = 0
    for period, state in enumerate(states):
        for qpos_ref, qvel_ref in zip(*track.advance(_swing(1, period), PERIOD, 20), strict=True):
            other.qpos = data.qpos
            mujoco.mj_forward(model, other)  # at rest: the bias is the weight
            torque = robot.servo.torque(data.qpos, data.qvel, qpos_ref[0], qvel_ref[0], other.qfrc_bias)
            saturated += int((np.abs(torque) == robot.servo.max_torque).any())
            data.qfrc_applied = torque
            mujoco.mj_step(model, data)
        assert_allclose(state.qpos[0], data.qpos, rtol=0.0, atol=1e-9)
    assert saturated > 10


def test_dm_control_moves_as_mujoco():
    """With drives that have limits, in every number."""
    ours, theirs = (_swung(kind(drive="servo"), 2, 15) for kind in (DmControl, Mujoco))
    for one, other in zip(ours, theirs, strict=True):
        for array, another in zip(one, other, strict=True):
            assert_allclose(array, another, rtol=0.0, atol=1e-9)


def test_checks_of_exact_tracking_are_left_out():
    """Drives with limits lag behind their targets, and break no contract by that."""
    checks = [check for check in CHECKS["simulator"] if check.name in EXACT]
    assert len(checks) == len(EXACT)
    assert list(violations(checks, Mujoco(drive="servo"), ROBOT)) == []


def test_drives_lag_behind_in_quick_motion_and_hold_still():
    """A degree or two on the way; next to nothing at rest: what dry friction keeps the stiffness from."""
    simulation = Mujoco(drive="servo").open(ROBOT, 1, PERIOD)
    errors = [np.abs(simulation.drive(_swing(1, k), PERIOD).qpos - _swing(1, k)).max() for k in range(20)]
    assert np.radians(0.5) < max(errors[5:]) < np.radians(5.0)
    for _ in range(10):
        state = simulation.drive(_swing(1, 19), PERIOD)
    left = np.abs(state.qpos - _swing(1, 19))[0]
    assert (left <= 1.05 * ROBOT.servo.dry_friction / ROBOT.servo.stiffness + 1e-4).all()


def test_a_drive_of_parts_of_a_period_follows_the_same_references():
    """Twice half a period is one period, bit for bit."""
    whole, halves = (Mujoco(drive="servo").open(ROBOT, 2, PERIOD) for _ in range(2))
    start, target = np.tile(ROBOT.home, (2, 1)), _swing(2, 3)
    for _ in range(3):
        whole.drive(target, PERIOD)
        halves.drive(start + (target - start) / 2, PERIOD / 2)
        halves.drive(target, PERIOD / 2)
        start = target
    assert_allclose(whole.read().qpos, halves.read().qpos, rtol=0.0, atol=1e-12)


@pytest.fixture(scope="module")
def folding(tmp_path_factory):
    """Three bars that turn about upright axes, 2 m above the ground: folded, the last one meets the first."""
    folder = tmp_path_factory.mktemp("folding")
    bar = """<link name="bar{0}"><inertial><origin xyz="0.2 0 0"/><mass value="2"/>
        <inertia ixx="0.001" iyy="0.03" izz="0.03" ixy="0" ixz="0" iyz="0"/></inertial>
        <collision><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.05 0.05"/></geometry></collision></link>
        <joint name="joint{0}" type="revolute"><parent link="{1}"/><child link="bar{0}"/><origin xyz="{2}"/>
        <axis xyz="0 0 1"/><limit lower="-2.6" upper="2.6" velocity="3" effort="1"/></joint>"""
    bars = [bar.format(1, "base", "0 0 2"), bar.format(2, "bar1", "0.4 0 0"), bar.format(3, "bar2", "0.4 0 0")]
    (folder / "arm.urdf").write_text(f'<robot name="arm"><link name="base"/>{"".join(bars)}</robot>')
    (folder / "robot.toml").write_text(
        "home_deg = [0, 20, 20]\n[servo]\nmax_torque_nm = [30, 30, 30]\narmature_kg_m2 = [0.5, 0.5, 0.5]\n"
        "stiffness_nm_per_rad = [1000, 500, 500]\ndamping_nms_per_rad = [60, 30, 30]\n"
    )
    return read_robot(folder / "arm.urdf")


FOLDED = np.radians([0.0, 125.0, 125.0])
"""The third bar in the first one."""


@pytest.mark.parametrize("kind", [Mujoco, DmControl])
@pytest.mark.parametrize("drive", ["ideal", "servo"])
def test_links_that_collide_hold_one_another_up(kind, drive, folding):
    """On the way into themselves links stop at one another, and pass through one another where they do not."""
    ends = {}
    for collides in (False, True):
        simulation = kind(drive=drive, self_collision=collides).open(folding, 1, PERIOD)
        for share in np.minimum(np.linspace(0.0, 1.2, 24)[1:], 1.0):
            state = simulation.drive((folding.home + share * (FOLDED - folding.home))[None], PERIOD)
        ends[collides] = float(np.degrees(np.abs(state.qpos[0] - FOLDED).max()))
    assert ends[False] < 0.1
    assert ends[True] > 1.0


def test_neighbours_and_what_touches_at_home_do_not_collide():
    """At home nothing touches anything, in either of the project's arms."""
    for name in ("fd100", "unity-arm"):
        robot = harness.load_robot(name)
        model = build_model(robot, STEP, 100.0, self_collision=True)
        data = mujoco.MjData(model)
        data.qpos = robot.home
        mujoco.mj_forward(model, data)
        assert data.ncon == 0


def test_links_that_collide_still_feel_the_ground():
    """Ground contact is told in the same poses."""
    poses = default_rng(1).uniform(ROBOT.lower, ROBOT.upper, (200, ROBOT.dof))
    placed = [Mujoco(self_collision=told).open(ROBOT, 200, PERIOD).place(poses) for told in (False, True)]
    without, collides = (state.ground_contact.copy() for state in placed)
    assert 20 < without.sum() < 180
    assert_array_equal(without, collides)
