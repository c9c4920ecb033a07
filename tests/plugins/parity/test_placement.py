"""Placement: poses over the whole ranges, errors against the robot's own kinematics."""

import numpy as np
import pytest

from harness_plugins.parity.track import place_at, placement_of, random_poses


def test_poses_cover_the_ranges(robot):
    """At least so many, uniform, the same for the same seed."""
    poses = random_poses(robot, 0, 7)
    assert poses.shape[1:] == (7, robot.dof)
    assert 64 <= poses.shape[0] * 7 < 64 + 7
    share = (poses - robot.lower) / (robot.upper - robot.lower)
    assert (share >= 0.0).all()
    assert (share <= 1.0).all()
    assert (share.min(axis=(0, 1)) < 0.1).all()
    assert (share.max(axis=(0, 1)) > 0.9).all()
    np.testing.assert_array_equal(poses, random_poses(robot, 0, 7))


@pytest.mark.parametrize(
    ("maker", "error_m", "error_rad"),
    [
        (lambda toolbox: toolbox.ideal, 0.0, 0.0),
        (lambda toolbox: toolbox.shifted_tip(-1e-3), 1e-3, 0.0),
        (lambda toolbox: toolbox.misplaced, None, 0.01),
    ],
)
def test_errors_are_those_that_were_made(robot, toolbox, maker, error_m, error_rad):
    """None in the ideal arm, a millimetre or a hundredth of a radian in wrong ones."""
    poses = random_poses(robot, 0, 3)
    placement = placement_of(place_at(maker(toolbox).open(robot, 3, 0.1), poses), robot, poses)
    assert placement.error_rad == pytest.approx(error_rad)
    if error_m is None:
        assert 1e-3 < placement.error_m < 0.1
    else:
        assert placement.error_m == pytest.approx(error_m, abs=1e-12)
