"""How far one orientation is turned from another."""

import numpy as np
from hypothesis import given, strategies as st
from numpy.linalg import norm
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from harness.robot import rotation_of_axes
from harness.robot.kinematics import rotation_between

QUATERNIONS = st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=4).filter(lambda q: norm(q) > 0.1)
ROTATIONS = QUATERNIONS.map(lambda q: Rotation.from_quat(q).as_matrix()[None])


def angle(one, other):
    """Between two orientations, [rad]."""
    return float(norm(rotation_between(one, other)))


@given(ROTATIONS, ROTATIONS)
def test_angle_is_the_same_both_ways(one, other):
    """And never more than half a turn."""
    assert abs(angle(one, other) - angle(other, one)) <= 1e-6
    assert angle(one, other) <= np.pi + 1e-9


@given(ROTATIONS, ROTATIONS, ROTATIONS)
def test_angle_does_not_depend_on_the_frame(one, other, frame):
    """A turn of both changes nothing."""
    assert abs(angle(one, other) - angle(frame @ one, frame @ other)) <= 1e-6


@given(ROTATIONS)
def test_angle_is_0_where_both_are_alike(one):
    """Up to rounding."""
    assert angle(one, one) <= 1e-7


@given(ROTATIONS, ROTATIONS)
def test_turn_leads_from_one_to_the_other(one, other):
    """In the world frame; so where there is none, they are alike."""
    assert_allclose(Rotation.from_rotvec(rotation_between(one, other)).as_matrix() @ one, other, atol=1e-7)


@given(ROTATIONS)
def test_two_axes_tell_a_rotation(one):
    """The third follows; single precision is mended."""
    axes = np.concatenate([one[:, :, 0], one[:, :, 1]], axis=1)
    assert_allclose(rotation_of_axes(axes), one, atol=1e-12)
    mended = rotation_of_axes(axes.astype(np.float32).astype(np.float64))
    assert_allclose(mended @ np.swapaxes(mended, 1, 2), np.eye(3)[None], atol=1e-12)
