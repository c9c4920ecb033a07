"""Forward kinematics and Jacobian of serial chains of every kind of joint."""

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.linalg import norm
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

from harness.robot import forward, parse_urdf
from harness.robot.kinematics import (
    build_chain,
    end_effector_position,
    pose_jacobian,
    position_jacobian,
    rotation_between,
)
from harness.robot.urdf import read_chain
from tests.refusals import refused

MASS = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'


def _joint(kind, parent, child, frame, axis="1 0 0"):
    """A link named `child`, and the joint of the same name that carries it."""
    return (
        f'<link name="{child}">{MASS}</link><joint name="{child}" type="{kind}">'
        f'<parent link="{parent}"/><child link="{child}"/><origin {frame}/><axis xyz="{axis}"/>'
        '<limit lower="-2" upper="2" velocity="1" effort="1"/></joint>'
    )


# Oblique axes and frames, every kind of joint, fixed ones before, between and behind the others.
ARM = (
    '<robot name="arm"><link name="base"/>'
    + _joint("fixed", "base", "post", 'xyz="0.1 -0.3 0.5" rpy="0.2 -0.4 2.0"')
    + _joint("continuous", "post", "turret", 'xyz="0 0.05 0.2" rpy="-0.3 0.1 0.7"', "0.2 -0.5 2")
    + _joint("revolute", "turret", "upper", 'xyz="0.3 0 0.1" rpy="1.1 0.3 -0.6"', "0 1 0")
    + _joint("fixed", "upper", "middle", 'xyz="0.2 0.1 0" rpy="0 1.2 0.4"')
    + _joint("prismatic", "middle", "slider", 'xyz="0 0 0.4" rpy="0.5 0.6 0.7"', "1 2 -3")
    + _joint("revolute", "slider", "wrist", 'xyz="0.1 0.2 0.3"', "-1 1 0.5")
    + _joint("fixed", "wrist", "adapter", 'xyz="0 0 0.07" rpy="0 0.8 0"')
    + _joint("fixed", "adapter", "tip", 'xyz="0.03 0.02 0.01" rpy="1 2 3"')
    + "</robot>"
)
CHAIN = build_chain(read_chain(parse_urdf(ARM), "tip"))

POSES = st.lists(st.floats(-2.0, 2.0), min_size=4, max_size=4).map(np.array)


def _random_poses(*shape):
    return default_rng(7).uniform(-2.0, 2.0, (*shape, CHAIN.dof))


def test_chain_holds_the_joints_that_move():
    """Fixed joints vanish from the chain, the others keep their order, and no array can be written to."""
    assert CHAIN.kinds == ("continuous", "revolute", "prismatic", "revolute")
    assert CHAIN.dof == 4
    assert CHAIN.T_previous_joint.shape == (4, 4, 4)
    assert_allclose(norm(CHAIN.axes, axis=-1), 1.0, rtol=1e-15)
    for array in (CHAIN.T_previous_joint, CHAIN.axes, CHAIN.T_last_tip, *CHAIN.terms):
        assert not array.flags.writeable


def test_pose_is_that_of_mujoco():
    """Position and orientation of the tip equal those that MuJoCo computes from the same URDF."""
    spec = mujoco.MjSpec.from_string(ARM)
    spec.compiler.fusestatic = False
    model = spec.compile()
    data = mujoco.MjData(model)
    for qpos in _random_poses(100):
        data.qpos[:] = qpos
        mujoco.mj_kinematics(model, data)
        T_world_tip = forward(CHAIN, qpos)
        assert_allclose(T_world_tip[:3, 3], data.body("tip").xpos, atol=1e-9)
        assert_allclose(T_world_tip[:3, :3], data.body("tip").xmat.reshape(3, 3), atol=1e-9)


def test_quarter_turn_and_slide_by_hand():
    """A crank of 2 m turned by 90 degrees about z and lifted by 0.5 m ends at (0, 2, 0.5)."""
    crank = build_chain(
        read_chain(
            parse_urdf(
                '<robot name="crank"><link name="base"/>'
                + _joint("revolute", "base", "arm", "", "0 0 1")
                + _joint("prismatic", "arm", "head", 'xyz="2 0 0"', "0 0 1")
                + "</robot>"
            ),
            "head",
        )
    )
    qpos = [np.pi / 2, 0.5]
    assert_allclose(end_effector_position(crank, qpos), [0.0, 2.0, 0.5], atol=1e-15)
    assert_allclose(position_jacobian(crank, qpos), [[-2.0, 0.0], [0.0, 0.0], [0.0, 1.0]], atol=1e-15)


def test_roll_pitch_yaw_turn_about_fixed_axes():
    """Roll of 90 degrees, then yaw of 90 degrees, turns z into x: z to -y about x, -y to x about z."""
    chain = build_chain(
        read_chain(
            parse_urdf(
                '<robot name="post"><link name="base"/>'
                + _joint("revolute", "base", "arm", f'rpy="{np.pi / 2!r} 0 {np.pi / 2!r}"', "0 0 1")
                + "</robot>"
            ),
            "arm",
        )
    )
    assert_allclose(forward(chain, [0.3])[:3, 2], [1.0, 0.0, 0.0], atol=1e-15)


def test_jacobian_is_the_derivative_of_the_position():
    """Each column equals the central difference of the position by that joint, turning or sliding."""
    qpos, step = _random_poses(50), 1e-6
    for joint in range(CHAIN.dof):
        change = step * np.eye(CHAIN.dof)[joint]
        ahead, behind = end_effector_position(CHAIN, qpos + change), end_effector_position(CHAIN, qpos - change)
        difference = (ahead - behind) / (2.0 * step)
        assert_allclose(position_jacobian(CHAIN, qpos)[..., joint], difference, atol=1e-8)


def test_batched_equals_looped():
    """Any leading axes give what row after row gives."""
    qpos = _random_poses(3, 5)
    poses, jacobians = forward(CHAIN, qpos), position_jacobian(CHAIN, qpos)
    positions = end_effector_position(CHAIN, qpos)
    assert (poses.shape, positions.shape, jacobians.shape) == ((3, 5, 4, 4), (3, 5, 3), (3, 5, 3, 4))
    for index in np.ndindex(3, 5):
        assert_allclose(forward(CHAIN, qpos[index]), poses[index], atol=1e-15)
        assert_allclose(end_effector_position(CHAIN, qpos[index]), positions[index], atol=1e-15)
        assert_allclose(position_jacobian(CHAIN, qpos[index]), jacobians[index], atol=1e-15)


def test_batch_may_be_empty():
    """No rows in, no rows out."""
    assert end_effector_position(CHAIN, np.zeros((0, 4))).shape == (0, 3)
    assert position_jacobian(CHAIN, np.zeros((0, 4))).shape == (0, 3, 4)


@settings(deadline=None)
@given(POSES)
def test_pose_is_a_rigid_transform(qpos):
    """The rotation is orthonormal and right-handed, and the last row stays 0 0 0 1."""
    T_world_tip = forward(CHAIN, qpos)
    rotation = T_world_tip[:3, :3]
    assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1.0)
    assert T_world_tip[3].tolist() == [0.0, 0.0, 0.0, 1.0]


@settings(deadline=None)
@given(POSES)
def test_whole_turns_change_nothing(qpos):
    """A turning joint is back after 2 pi; a sliding one is 2 pi metres further along its axis."""
    moved = end_effector_position(CHAIN, qpos + 2.0 * np.pi) - end_effector_position(CHAIN, qpos)
    assert_allclose(moved, 2.0 * np.pi * position_jacobian(CHAIN, qpos)[:, 2], atol=1e-12)


def test_wrong_shape_is_refused(subtests):
    """Positions that are not one per joint are refused, also where they would broadcast."""
    for compute in [forward, end_effector_position, position_jacobian]:
        for shape in [(), (1,), (3,), (5,), (4, 1), (2, 5)]:
            told = refused(r"qpos has shape \(.*\), allowed is \(\.\.\., 4\)")
            with subtests.test(compute=compute, shape=shape), told:
                compute(CHAIN, np.zeros(shape))


@given(POSES)
@settings(max_examples=20)
def test_lower_half_of_the_jacobian_is_the_turn(qpos):
    """Against finite differences, for joints that turn and one that slides; the upper half is that of the position."""
    jacobian, step = pose_jacobian(CHAIN, qpos), 1e-5
    assert_array_equal(jacobian[:3], position_jacobian(CHAIN, qpos))
    for joint in range(CHAIN.dof):
        moved = step * np.eye(CHAIN.dof)[joint]
        before, after = (forward(CHAIN, qpos + way)[None, :3, :3] for way in (-moved, moved))
        turn = rotation_between(before, after)[0] / (2.0 * step)
        assert_allclose(jacobian[3:, joint], turn, atol=1e-6)
