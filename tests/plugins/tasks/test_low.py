"""Targets just above the ground, and targets that have to be met closely."""

import numpy as np
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

from harness.robot import reach_position
from harness.simulator import GroundContact
from harness_plugins.tasks.low import Low
from harness_plugins.tasks.small_target import SmallTarget
from tests.registered import FD100 as ROBOT, UNITY_ARM
from tests.robot.brought_arms import changed, read_arm


def test_targets_are_low_and_can_be_touched():
    """Within 10 cm of the ground, and for each there is a pose at it that does not touch the ground."""
    targets = Low().draw_targets(ROBOT, default_rng(0), 100).position
    assert targets[:, 2].min() > 0.0
    assert targets[:, 2].max() < 0.1
    qpos, reached = reach_position(ROBOT, targets, np.tile(ROBOT.home, (100, 1)))
    assert (reached & ~GroundContact(ROBOT)(qpos)).all()


def test_box_of_another_arm_is_scaled_by_its_reach():
    """As that of `fd100-reach`; one that is given stays as it is."""
    scale = UNITY_ARM.reach / ROBOT.reach
    assert_allclose(Low().target_box(UNITY_ARM), scale * np.array(Low().target_box(ROBOT)), rtol=1e-12)
    given = Low(target_center=(0.5, 0.1, 0.6), target_half_extent=(0.1, 0.2, 0.0))
    assert_array_equal(given.target_box(UNITY_ARM), [(0.5, 0.1, 0.6), (0.1, 0.2, 0.0)])


def test_box_stays_at_the_ground_and_follows_a_mount_aside(tmp_path):
    """The ground is where it is, whatever an arm stands on."""
    arms = (read_arm(tmp_path / str(x), changed(('xyz="0 0 0.1" rpy', f'xyz="{x} 0 0.8" rpy'))) for x in (0, 2))
    (center, _), (moved, _) = map(Low().target_box, arms)
    assert center[2] == moved[2] < 0.1
    assert 1.5 < moved[0] - center[0] < 2.0


def test_small_target_is_a_fifth_of_the_usual():
    """All else is that of `fd100-reach`."""
    assert SmallTarget().epsilon == 0.01
    one, other = (task.draw_targets(ROBOT, default_rng(1), 5) for task in (SmallTarget(), Low()))
    assert one.position.shape == other.position.shape == (5, 3)
