"""Drift: distances of two tracks, by hand."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harness_plugins.parity.track import Track, drift_between


@pytest.fixture
def tracks():
    """Three rows, two episodes, two joints; the second is off in episode 0 at row 1 and in both at row 2."""
    first = Track(np.zeros((3, 2, 2)), np.zeros((3, 2, 3)), np.zeros((3, 2), bool))
    second = Track(np.zeros((3, 2, 2)), np.zeros((3, 2, 3)), np.zeros((3, 2), bool))
    second.tip[1, 0] = [3.0, 4.0, 0.0]
    second.tip[2] = [[0.0, 0.0, 2.0], [0.0, 0.0, -1.0]]
    second.qpos[2, 1] = [0.1, -0.3]
    return first, second


def test_figures_by_hand(tracks):
    """The mean leaves the start out."""
    drift = drift_between(*tracks)
    assert drift.max_tip_error_m == 5.0
    assert drift.mean_tip_error_m == pytest.approx((5 + 0 + 2 + 1) / 4)
    assert drift.max_joint_error_rad == pytest.approx(0.3)


def test_curves_by_hand(tracks):
    """One value per row, over the episodes."""
    curves = drift_between(*tracks).curves
    assert_allclose(curves["max_tip_error_m"], [0.0, 5.0, 2.0])
    assert_allclose(curves["mean_tip_error_m"], [0.0, 2.5, 1.5])
    assert_allclose(curves["max_joint_error_rad"], [0.0, 0.0, 0.3])
