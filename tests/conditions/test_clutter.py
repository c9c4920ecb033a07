"""Obstacles that an episode draws."""

import numpy as np
from numpy.random import default_rng
from numpy.testing import assert_allclose

from harness.conditions.clearance import MARGIN, Clearance, draw_clutter
from harness.conditions.conditions import Conditions
from harness.conditions.obstacles import distance_from, there
from harness.robot import reach_position
from harness.task import ReachTask
from tests.registered import FD100 as ARM

CLEARANCE = Clearance(ARM)
CROWDED = Conditions(obstacle_count=3)


def drawn(seed):
    """Start, target and obstacles of an episode."""
    rng, task = default_rng(seed), ReachTask()
    start, target = task.draw_start(ARM, rng), task.draw_targets(ARM, rng, 1).position[0]
    return start, target, draw_clutter(CROWDED, ARM, CLEARANCE, start, target, task.epsilon, rng)


def test_start_and_target_stay_free(subtests):
    """By the margin; and so does a pose in which the arm reaches the target."""
    for seed in range(6):
        with subtests.test(seed=seed):
            start, target, obstacles = drawn(seed)
            present = obstacles[there(obstacles)]
            assert len(present)
            assert (distance_from(target, present) > 0.05 + MARGIN).all()
            assert CLEARANCE.distance(start[None], present[None])[0] > CROWDED.obstacle_clearance + MARGIN - 1e-6
            goal, _ = reach_position(ARM, target[None], start[None])
            assert not CLEARANCE.touches(goal, present[None], CROWDED.obstacle_clearance)[0]


def test_some_straight_ways_are_blocked():
    """Obstacles that nobody meets would be no obstacles."""
    blocked = 0
    for seed in range(20):
        start, target, obstacles = drawn(seed)
        goal, _ = reach_position(ARM, target[None], start[None])
        way = start + np.linspace(0.0, 1.0, 20)[:, None] * (goal[0] - start)
        blocked += CLEARANCE.touches(way, np.tile(obstacles, (20, 1, 1)), CROWDED.obstacle_clearance).any()
    assert 3 <= blocked <= 17


def test_spheres_and_boxes_are_drawn_in_their_sizes():
    """Half of each, about."""
    present = np.concatenate([obstacles[there(obstacles)] for _, _, obstacles in map(drawn, range(20))])
    sizes = present[:, 3:][present[:, 3:] > 0.0]
    assert 0.2 < (present[:, 6] > 0.0).mean() < 0.8
    assert (sizes >= 0.04).all()
    assert (sizes <= 0.1).all()


def test_fixed_ones_come_first():
    """A task may have both."""
    both = Conditions(obstacles="0.3x0.6x0.5x0.05", obstacle_count=1)
    rng, task = default_rng(0), ReachTask()
    target = task.draw_targets(ARM, rng, 1).position[0]
    obstacles = draw_clutter(both, ARM, CLEARANCE, ARM.home.copy(), target, 0.05, rng)
    assert_allclose(obstacles[0], [0.3, 0.6, 0.5, 0, 0, 0, 0.05])
    assert obstacles.shape == (2, 7)
