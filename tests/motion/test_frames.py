"""World, user's and tool's axes."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.linalg import norm
from numpy.testing import assert_allclose, assert_array_equal

from harness.motion.tip import CartesianMode
from harness.robot import forward
from tests.refusals import refused

COORDINATE = st.floats(-2.0, 2.0).map(lambda number: round(number, 2))
POINT = st.tuples(COORDINATE, COORDINATE, COORDINATE)


def test_world_axes_change_nothing(fd100):
    """In the WCS a vector is what it is."""
    assert_array_equal(CartesianMode().axes(fd100).to_world(fd100.home[None], np.eye(3)[None])[0], np.eye(3))


def test_users_axes_of_a_turned_table(fd100):
    """Origin, a point on +x and one in the first quadrant of the xy plane give the axes (note 105c)."""
    mode = CartesianMode(frame="ucs", ucs_origin=(1.0, 1.0, 0.5), ucs_x=(1.0, 3.0, 0.5), ucs_xy=(0.2, 1.7, 0.5))
    x, y, z = mode.axes(fd100).to_world(fd100.home[None], np.eye(3)[None])[0]
    assert_allclose([x, y, z], [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], atol=1e-12)


@given(origin=POINT, on_x=POINT, on_xy=POINT)
def test_users_axes_are_right_handed_and_through_the_points(fd100, origin, on_x, on_xy):
    """The axes are a rotation; the second point has positive x and no y nor z, the third positive y and no z."""
    edges = np.array(on_x) - origin, np.array(on_xy) - origin
    if norm(np.cross(*edges)) < 1e-3:
        return
    mode = CartesianMode(frame="ucs", ucs_origin=origin, ucs_x=on_x, ucs_xy=on_xy)
    columns = mode.axes(fd100).to_world(fd100.home[None], np.eye(3)[None])[0].T
    assert_allclose(columns.T @ columns, np.eye(3), atol=1e-9)
    assert np.linalg.det(columns) == pytest.approx(1.0)
    x_point, xy_point = (columns.T @ edge for edge in edges)
    assert_allclose(x_point, [norm(edges[0]), 0.0, 0.0], atol=1e-9)
    assert xy_point[1] > 0.0
    assert xy_point[2] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("points", [((0, 0, 0), (1, 0, 0), (2, 0, 0)), ((1, 2, 3), (1, 2, 3), (0, 1, 0))])
def test_points_on_one_line_are_a_usage_error(fd100, points):
    """Three points that span no plane are refused, with the three."""
    mode = CartesianMode(frame="ucs", ucs_origin=points[0], ucs_x=points[1], ucs_xy=points[2])
    with refused("one line"):
        mode.axes(fd100)


def test_points_on_one_line_do_not_matter_in_another_frame(fd100):
    """The user's points are looked at where the frame is the user's."""
    CartesianMode(frame="wcs", ucs_x=(0.0, 0.0, 0.0)).axes(fd100)


def test_tool_axes_are_those_of_the_end_effector(arm, poses):
    """In the TCS a vector turns with the end effector's link."""
    qpos, vector = poses(arm, 20), np.array([0.1, -0.2, 0.3])
    turned = CartesianMode(frame="tcs").axes(arm).to_world(qpos, np.tile(vector, (20, 1, 1)))[:, 0]
    assert_allclose(turned, forward(arm.chain, qpos)[:, :3, :3] @ vector)


def test_tool_z_leads_out_of_the_flange(fd100):
    """The FD100's tool z is the direction of its last axis (note 105c)."""
    axes = CartesianMode(frame="tcs").axes(fd100)
    z = axes.to_world(fd100.home[None], np.array([[[0.0, 0.0, 1.0]]]))[0, 0]
    turned = fd100.home + np.eye(6)[5]
    assert_allclose(axes.to_world(turned[None], np.array([[[0.0, 0.0, 1.0]]]))[0, 0], z, atol=1e-9)
    assert_allclose(fd100.end_effector(turned), fd100.end_effector(fd100.home), atol=1e-9)
