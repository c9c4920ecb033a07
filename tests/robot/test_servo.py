"""The drives that a robot.toml describes."""

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.random import default_rng
from numpy.testing import assert_array_equal

import harness
from harness.robot import Servo
from harness.robot.energy import energy, read_bodies
from harness.robot.robot import read_robot
from tests.refusals import refused
from tests.registered import FD100

URDF = """
<robot name="arm">
  <link name="base"/> <link name="upper"/> <link name="lower"/> <link name="tip"/>
  <joint name="shoulder" type="revolute">
    <parent link="base"/> <child link="upper"/> <origin xyz="0 0 5"/> <axis xyz="0 0 1"/>
    <limit lower="-1" upper="2" velocity="1" effort="1"/>
  </joint>
  <joint name="slide" type="prismatic">
    <parent link="upper"/> <child link="lower"/> <origin xyz="0.5 0 0"/> <axis xyz="0 0 1"/>
    <limit lower="-0.2" upper="0.1" velocity="0.5" effort="1"/>
  </joint>
  <joint name="elbow" type="revolute">
    <parent link="lower"/> <child link="tip"/> <origin xyz="0.5 0 0"/> <axis xyz="0 0 1"/>
    <limit lower="-1" upper="2" velocity="1" effort="1"/>
  </joint>
</robot>
"""
TOML = """
home_deg = [0, 60]
home_m = [0]

[servo]
max_torque_nm = [10, 20]
max_force_n = [300]
armature_kg_m2 = [0.1, 0]
armature_kg = [4]
viscous_friction_nms_per_rad = [0.5, 0.6]
viscous_friction_ns_per_m = [7]
dry_friction_nm = [1, 2]
dry_friction_n = [30]
stiffness_nm_per_rad = [100, 200]
stiffness_n_per_m = [3000]
damping_nms_per_rad = [8, 9]
damping_ns_per_m = [70]
latency_s = 0.012
gravity_compensated = false
"""
OPTIONAL = ("viscous", "dry", "latency", "gravity")


def _read(folder, toml=TOML, urdf=URDF):
    (folder / "robot.toml").write_text(toml)
    (folder / "arm.urdf").write_text(urdf)
    return read_robot(folder / "arm.urdf")


def _servo(**changes):
    one = np.ones(2)
    given = dict.fromkeys(("max_torque", "armature", "viscous_friction", "dry_friction", "stiffness", "damping"), one)
    return Servo(**{**given, "latency": 0.0, "gravity_compensated": True, **changes})


def test_drives_are_what_the_table_says(tmp_path):
    """One value per joint in the order of the chain, those of joints that slide from keys of their own."""
    servo = _read(tmp_path).servo
    assert_array_equal(servo.max_torque, [10, 300, 20])
    assert_array_equal(servo.armature, [0.1, 4, 0])
    assert_array_equal(servo.viscous_friction, [0.5, 7, 0.6])
    assert_array_equal(servo.dry_friction, [1, 30, 2])
    assert_array_equal(servo.stiffness, [100, 3000, 200])
    assert_array_equal(servo.damping, [8, 70, 9])
    assert (servo.latency, servo.gravity_compensated) == (0.012, False)


def test_friction_and_latency_may_be_left_out(tmp_path):
    """They are 0 then, and gravity is compensated."""
    servo = _read(tmp_path, "\n".join(line for line in TOML.splitlines() if not line.startswith(OPTIONAL))).servo
    assert not servo.viscous_friction.any()
    assert not servo.dry_friction.any()
    assert (servo.latency, servo.gravity_compensated) == (0.0, True)


def test_an_arm_without_the_table_has_no_drives(tmp_path):
    """Most robots have none."""
    assert _read(tmp_path, "home_deg = [0, 60]\n").servo is None


def test_drives_cannot_be_changed(tmp_path):
    """Neither the arrays nor the rest."""
    servo = _read(tmp_path).servo
    with pytest.raises(ValueError, match="read-only"):
        servo.stiffness[0] = 1.0
    with pytest.raises(FrozenInstanceError):
        servo.latency = 1.0


def test_torque_that_is_left_out_is_the_effort_of_the_urdf(tmp_path):
    """One by one, where there is one above 0; else it is missing."""
    some = TOML.replace("[10, 20]", "{ elbow = 20 }").replace("max_force_n = [300]\n", "")
    assert_array_equal(_read(tmp_path, some, URDF.replace('"1"', '"7"')).servo.max_torque, [7, 7, 20])
    for effort in ("0", "-1", "", "x"):
        with refused(r"\[servo\]: missing max_torque_nm of 'shoulder'. Give one value per"):
            _read(tmp_path, some, URDF.replace('effort="1"', f'effort="{effort}"'))


def test_bad_drives_are_refused_in_one_line(tmp_path_factory, subtests):
    """Each fault is a UsageError of one line that names the file and the table."""
    for old, new, message in [
        ("[servo]", "servo = 5", r"robot.toml: servo is 5. Write a table: \[servo\], and its keys below."),
        ("latency_s", "delay_s", r"robot.toml: \[servo\]: unknown delay_s. The keys are max_torque_nm, max_force_n"),
        (
            "stiffness_n_per_m = [3000]",
            "",
            r"\[servo\]: missing stiffness_n_per_m of 'slide'. Give one value per",
        ),
        ("[10, 20]", "[10]", r"\[servo\]: max_torque_nm has 1 values for 2 turning joints. Give one per joint."),
        ("[10, 20]", "[10, 0]", r"\[servo\]: max_torque_nm of 'elbow' is 0. Give a positive value."),
        ("[100, 200]", "[-1, 2]", r"\[servo\]: stiffness_nm_per_rad of 'shoulder' is -1. Give a positive value."),
        ("[8, 9]", "[8, -9]", r"\[servo\]: damping_nms_per_rad of 'elbow' is -9. Give 0 or more."),
        ("[70]", "[inf]", r"\[servo\]: damping_ns_per_m is \[inf\]. Give a list of 1 finite numbers, one per sliding"),
        ("0.012", "-1", r"\[servo\]: latency_s is -1. Give 0 or more."),
        ("0.012", '"soon"', r"\[servo\]: latency_s is 'soon'. Give a finite number."),
        ("= false", "= 1", r"\[servo\]: gravity_compensated is 1. Give true or false."),
    ]:
        with subtests.test(old=old):
            tmp_path = tmp_path_factory.mktemp("case")
            toml = TOML.replace(old, new) if new != "servo = 5" else "servo = 5\n" + TOML[: TOML.index("[servo]")]
            assert toml != TOML
            with refused(message):
                _read(tmp_path, toml)


@given(st.lists(st.floats(-1e3, 1e3), min_size=10, max_size=10))
def test_torque_is_the_law_within_the_limits(numbers):
    """Stiffness times the error, damping times the error in speed, and the weight; never more than the limit."""
    servo = _servo(max_torque=np.array([50.0, 5000.0]), stiffness=np.array([3.0, 2.0]), damping=np.array([0.5, 4.0]))
    q, v, q_ref, v_ref, gravity = np.reshape(numbers, (5, 2))
    torque = servo.torque(q, v, q_ref, v_ref, gravity)
    assert (np.abs(torque) <= servo.max_torque).all()
    for j in range(2):
        wanted = servo.stiffness[j] * (q_ref[j] - q[j]) + servo.damping[j] * (v_ref[j] - v[j]) + gravity[j]
        assert torque[j] == pytest.approx(min(max(wanted, -servo.max_torque[j]), servo.max_torque[j]))


def test_weight_counts_only_where_it_is_compensated():
    """A drive that does not know of it does not hold it."""
    at_rest = (np.zeros(2),) * 4
    assert _servo(gravity_compensated=True).torque(*at_rest, gravity=[0.5, 7.0]).tolist() == [0.5, 1.0]
    assert _servo(gravity_compensated=False).torque(*at_rest, gravity=[0.5, 7.0]).tolist() == [0.0, 0.0]


def test_latency_is_rounded_to_physics_steps(subtests):
    """To the nearest; halves go up."""
    for latency, steps in [(0.0, 0), (0.002, 0), (0.0025, 1), (0.007, 1), (0.01, 2), (0.1, 20)]:
        with subtests.test(latency=latency, steps=steps):
            assert _servo(latency=latency).delay(0.005) == steps


def test_digest_is_that_of_the_numbers():
    """Each of them counts, and the order of what is equal does not hide one."""
    changes = [
        {}, {"max_torque": 2 * np.ones(2)}, {"armature": 2 * np.ones(2)}, {"damping": np.array([1.0, 2.0])},
        {"damping": np.array([2.0, 1.0])}, {"latency": 0.1}, {"gravity_compensated": False},
    ]  # fmt: skip
    assert len({_servo(**change).digest for change in changes}) == len(changes)
    assert _servo().digest == _servo().digest


def test_drives_count_only_where_the_arm_is_driven_by_them():
    """`Robot.digest` is what it was before there were drives; `driven_digest` has them in it."""
    stronger = replace(FD100, servo=replace(FD100.servo, latency=0.02))
    without = replace(FD100, servo=None)
    assert len({each.digest for each in (FD100, stronger, without)}) == 1
    assert len({each.driven_digest for each in (FD100, stronger, without)}) == 3
    assert without.driven_digest == without.digest


@pytest.mark.parametrize("name", ["fd100", "unity-arm"])
def test_own_arms_have_drives_that_steps_of_5_ms_can_follow(name):
    """An explicit step is stable below 2: dt times the largest eigenvalue of (inertia + armature)^-1 damping.

    So is a step of an undamped spring, dt times its frequency. Both are below 1 in every one of many poses.
    """
    robot = harness.load_robot(name)
    servo, step, rng = robot.servo, 0.005, default_rng(0)
    for pose in [robot.home, *rng.uniform(robot.lower, robot.upper, (100, robot.dof))]:
        inertia = _joint_inertia(robot, pose) + np.diag(servo.armature)
        rates = np.linalg.eigvals(np.linalg.solve(inertia, np.diag(servo.damping + servo.viscous_friction)))
        frequencies = np.sqrt(np.linalg.eigvals(np.linalg.solve(inertia, np.diag(servo.stiffness))))
        assert step * np.abs(rates).max() < 1.0
        assert step * np.abs(frequencies).max() < 1.0


@pytest.mark.parametrize("name", ["fd100", "unity-arm"])
def test_own_arms_can_hold_their_weight(name):
    """In every one of many poses the drives have more than half of their torque left for the motion."""
    robot = harness.load_robot(name)
    poses, small = default_rng(0).uniform(robot.lower, robot.upper, (500, robot.dof)), 1e-6
    bodies, rest = read_bodies(robot), np.zeros((500, robot.dof))
    for j in range(robot.dof):
        step = small * np.eye(robot.dof)[j]
        up, down = (energy(robot.chain, bodies, poses + way, rest) for way in (step, -step))
        assert np.abs(up - down).max() / (2.0 * small) < 0.5 * robot.servo.max_torque[j]


def _joint_inertia(robot, pose):
    """The joint-space inertia of the links, (dof, dof), from their kinetic energy."""
    pairs = np.array([[a + b for b in np.eye(robot.dof)] for a in np.eye(robot.dof)])
    poses, bodies = np.broadcast_to(pose, pairs.shape), read_bodies(robot)
    kinetic = energy(robot.chain, bodies, poses, pairs) - energy(robot.chain, bodies, poses, 0.0 * pairs)
    own = np.diag(kinetic) / 4.0
    return kinetic - own[:, None] - own
