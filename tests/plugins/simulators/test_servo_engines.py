"""Drives with limits and links that collide, in the engines that step one arm: by hand, and beside MuJoCo."""

import hashlib
import subprocess
import sys
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harness.registry import choose
from harness.robot.energy import energy, read_bodies
from harness.robot.robot import read_robot
from harness.simulator import State
from tests.plugins.simulators.conftest import PERIOD, REGISTRY, ROBOT, open_simulator
from tests.refusals import refused

STEP = 0.005

pytestmark = pytest.mark.usefixtures("installed")
APART = {"drake": 1e-4, "physx": 0.015, "pybullet": 1e-4}
"""How far a joint may be from where it is with MuJoCo, [rad]; PhysX divides a physics step by itself."""
every_engine = pytest.mark.parametrize("simulator", APART)
with_servos = pytest.mark.parametrize("simulator", [*APART, "mujoco", "dm_control"])


def with_drives(**changes):
    """The FD100 with other drives."""
    return replace(ROBOT, servo=replace(ROBOT.servo, **changes))


def driven(name, targets, robot=ROBOT, **settings):
    """The states at the ends of the periods of one arm that begins at home, each array (periods, ...)."""
    simulation = open_simulator(name, 1, robot, drive="servo", **settings)
    states = [[array[0].copy() for array in simulation.drive(qpos[None], PERIOD)] for qpos in targets]
    simulation.close()
    return State._make(np.array(arrays) for arrays in zip(*states, strict=True))


def swing(periods):
    """Targets of a quick motion of all joints."""
    return ROBOT.home + 0.4 * np.sin(0.15 * np.arange(1, periods + 1)[:, None] + np.arange(6)) * [1, 0.5, 0.5, 1, 1, 1]


JUMP = np.tile(ROBOT.home + np.array([0.8, -0.4, 0.3, 1.0, -1.0, 1.0]), (6, 1))
"""Far away at once, where the drives have not enough torque."""


@cache
def of_mujoco(motion):
    """What the simulator on another engine does."""
    return driven("mujoco", {"swing": swing(12), "jump": JUMP}[motion])


@every_engine
@pytest.mark.parametrize("motion", ["swing", "jump"])
def test_arm_moves_as_with_mujoco(simulator, motion):
    """Torque limits, armature, both frictions and latency are the same in another engine."""
    ours, theirs = driven(simulator, {"swing": swing(12), "jump": JUMP}[motion]), of_mujoco(motion)
    assert np.abs(theirs.qpos - ROBOT.home).max() > 0.3
    assert np.abs(ours.qpos - theirs.qpos).max() < APART[simulator]


LINK = """<link name="{0}"><inertial><origin xyz="0.1 0.02 0.05" rpy="0.3 0.2 0.1"/><mass value="{1}"/>
    <inertia ixx="0.02" iyy="0.03" izz="0.025" ixy="0.002" ixz="0.001" iyz="0"/></inertial></link>"""
JOINT = """<joint name="of_{1}" type="{2}"><parent link="{0}"/><child link="{1}"/>
    <origin xyz="0.2 0 {3}" rpy="0.2 0.1 0"/><axis xyz="{4}"/>
    <limit lower="-1.5" upper="1.5" velocity="2" effort="1"/></joint>"""
SLIDING = f"""<robot name="sliding"><link name="base"/>{LINK.format("a", 4)}{LINK.format("b", 3)}{LINK.format("c", 2)}
    {JOINT.format("base", "a", "revolute", 0.8, "0 0 1")}{JOINT.format("a", "b", "prismatic", 0.3, "0 0.6 0.8")}
    {JOINT.format("b", "c", "revolute", 0.0, "0.6 0.8 0")}</robot>"""
SERVO = """home_deg = [0, 20]
home_m = [0.1]
[servo]
max_torque_nm = [60, 30]
max_force_n = [200]
armature_kg_m2 = [0.5, 0.3]
armature_kg = [5]
stiffness_nm_per_rad = [800, 500]
stiffness_n_per_m = [9000]
damping_nms_per_rad = [50, 25]
damping_ns_per_m = [600]
viscous_friction_nms_per_rad = [1, 1]
viscous_friction_ns_per_m = [10]
dry_friction_nm = [2, 1]
dry_friction_n = [8]
"""


@every_engine
def test_joints_that_slide_and_axes_askew_move_as_with_mujoco(simulator, tmp_path):
    """An armature in kg, and ones about axes that are no principal axes of their links, count as with MuJoCo."""
    (tmp_path / "sliding.urdf").write_text(SLIDING)
    (tmp_path / "robot.toml").write_text(SERVO)
    robot = read_robot(tmp_path / "sliding.urdf")
    targets = robot.home + 0.3 * np.sin(0.2 * np.arange(1, 9)[:, None] + np.arange(3))
    ours, theirs = (driven(name, targets, robot) for name in (simulator, "mujoco"))
    assert np.abs(theirs.qpos - targets).max() > 0.05
    assert np.abs(ours.qpos - theirs.qpos).max() < APART[simulator]


def heavy(**changes):
    """Drives whose armature is all that counts, without latency and friction, critically damped at 10 rad/s."""
    inertia = np.full(6, 1e5)
    return with_drives(
        armature=inertia, stiffness=100.0 * inertia, damping=20.0 * inertia, latency=0.0,
        viscous_friction=np.zeros(6), dry_friction=np.zeros(6), **changes,
    )  # fmt: skip


@every_engine
def test_step_response_is_that_of_a_spring_and_a_damper(simulator):
    """After a ramp of one period each joint comes in as x'' = 100 (ref - x) + 20 (ref' - x') does, to 1 % of it.

    In physics steps of 0.5 ms: those of 5 ms are 4 % off.
    """
    way, robot = np.array([0.1, 0.1, 0.1, -0.1, 0.1, -0.1]), heavy(max_torque=np.full(6, 1e9))
    went = (driven(simulator, np.tile(ROBOT.home + way, (8, 1)), robot, substeps=200).qpos - ROBOT.home) / way
    position, speed, exact, fine = 0.0, 0.0, [], 1e-4
    for step in range(round(8 * PERIOD / fine)):
        reference, rate = min(step * fine / PERIOD, 1.0), float(step * fine < PERIOD) / PERIOD
        speed += fine * (100.0 * (reference - position) + 20.0 * (rate - speed))
        position += fine * speed
        exact.append(position)
    at_ends = np.array(exact[round(PERIOD / fine) - 1 :: round(PERIOD / fine)])
    assert np.abs(at_ends - 1.0).max() > 0.1
    assert_allclose(went, np.tile(at_ends[:, None], 6), atol=0.01)


@every_engine
def test_limited_torque_gives_a_limited_acceleration(simulator):
    """A drive at its limit speeds up by torque / armature: after 0.2 s a joint goes by torque / armature x 0.2 s."""
    robot = heavy(max_torque=np.full(6, 5e4))
    speeds = driven(simulator, np.tile(ROBOT.home + 1.0, (2, 1)), robot).qvel[-1]
    assert_allclose(speeds, 0.5 * 2.0 * PERIOD, rtol=0.06)  # the first physics step has no error yet


@with_servos
def test_arm_sags_until_the_stiffness_carries_its_weight(simulator):
    """Where gravity is not compensated: stiffness times the angle is the change of potential energy per angle."""
    robot = with_drives(gravity_compensated=False, dry_friction=np.zeros(6))
    qpos = driven(simulator, np.tile(ROBOT.home, (12, 1)), robot).qpos[-1]
    near = qpos + 1e-6 * np.concatenate([np.eye(6), -np.eye(6)])
    potential = energy(ROBOT.chain, read_bodies(ROBOT), near, np.zeros_like(near))
    weight = (potential[:6] - potential[6:]) / 2e-6
    assert np.abs(weight).max() > 100.0
    assert_allclose(ROBOT.servo.stiffness * (ROBOT.home - qpos), weight, atol=1.0)


@with_servos
def test_arm_that_is_compensated_does_not_sag(simulator):
    """Its drives hold the weight, without friction to help them."""
    state = driven(simulator, np.tile(ROBOT.home, (10, 1)), with_drives(dry_friction=np.zeros(6)))
    assert np.abs(state.qpos - ROBOT.home).max() < 1e-5


@every_engine
def test_weight_beyond_the_limit_pulls_the_arm_down(simulator):
    """Compensation is a part of the torque: with 60 N m at joint 2 the arm falls."""
    weak = with_drives(max_torque=np.array([600.0, 60.0, 250.0, 60.0, 60.0, 30.0]))
    assert driven(simulator, np.tile(ROBOT.home, (3, 1)), weak).qpos[-1, 1] - ROBOT.home[1] > 0.01


@every_engine
def test_dry_friction_holds_a_joint_off_its_target(simulator):
    """A move whose torque stays below the friction moves nothing."""
    target = np.tile(ROBOT.home + 0.9 * ROBOT.servo.dry_friction / ROBOT.servo.stiffness, (5, 1))
    assert np.abs(driven(simulator, target, with_drives(damping=np.zeros(6))).qpos - ROBOT.home).max() < 1e-4


@with_servos
def test_new_fields_leave_cells_as_they_were(simulator):
    """They show in a choice only where they are not at their defaults."""
    plain = choose(REGISTRY, "simulators", simulator)
    assert choose(REGISTRY, "simulators", f"{simulator}:drive=ideal,self_collision=false") == plain
    assert not {"drive", "self_collision"} & set(dict(plain.params))
    servo = choose(REGISTRY, "simulators", f"{simulator}:drive=servo")
    assert (dict(servo.params)["drive"], servo.label) == ("servo", f"{simulator}:drive=servo")


@with_servos
def test_robot_without_drives_is_refused(simulator):
    """One line names the robot and what is missing."""
    with refused(r"'fd100' has no drives to simulate: its robot.toml has no table \[servo\]"):
        driven(simulator, JUMP, replace(ROBOT, servo=None))


FOLDED = np.radians([-98.0, 26.0, 80.0, 7.5, 73.6, -169.0])
"""The FD100's flange 13 mm in its first link, above the ground."""


@every_engine
def test_links_that_collide_hold_one_another_up(simulator):
    """On the way into itself the arm stops as with MuJoCo, to half a degree; else it gets there. No ground is told."""
    way = ROBOT.home + np.minimum(np.linspace(0.1, 1.3, 13), 1.0)[:, None] * (FOLDED - ROBOT.home)
    off, on = (driven(simulator, way, self_collision=collides) for collides in (False, True))
    assert np.degrees(np.abs(off.qpos[-1] - FOLDED)).max() < 0.5
    assert np.degrees(np.abs(on.qpos[-1] - FOLDED)).max() > 0.8
    theirs = driven("mujoco", way, self_collision=True)
    assert not any(arm.ground_contact.any() for arm in (off, on, theirs))
    assert np.degrees(np.abs(on.qpos[-1] - theirs.qpos[-1])).max() < 0.8


@every_engine
def test_what_touches_at_home_does_not_collide(simulator):
    """An arm about home that may touch itself moves as one that may not, but for rounding to single precision."""
    apart, together = (driven(simulator, swing(4), self_collision=collides) for collides in (False, True))
    assert_allclose(apart.qpos, together.qpos, atol=1e-6)


DIGEST = """
import sys; from tests.plugins.simulators.test_servo_engines import digest
print(digest(sys.argv[1]))
"""


def digest(simulator):
    """Of all that an arm with drives tells along a motion."""
    return hashlib.sha256(b"".join(array.tobytes() for array in driven(simulator, swing(8)))).hexdigest()


@every_engine
@pytest.mark.slow
def test_another_process_computes_the_same(simulator, request):
    """Bit for bit; as does the same process a second time."""
    assert digest(simulator) == digest(simulator)
    command = [sys.executable, "-W", "ignore", "-c", DIGEST, simulator]
    other = subprocess.run(
        command, cwd=request.config.rootpath, capture_output=True, text=True, check=True, timeout=120
    )
    assert other.stdout.split()[-1] == digest(simulator)
