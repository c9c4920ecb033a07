"""Arms without an engine."""

import numpy as np
from numpy.random import default_rng
from numpy.testing import assert_array_equal

from harness_plugins.kit import IdealSimulator
from tests.registered import FD100 as ROBOT


def test_arms_that_rest_change_nothing_of_the_others():
    """Bit for bit; and once they are woken they are like the others again."""
    rng = default_rng(0)
    one, other = (IdealSimulator().open(ROBOT, 6, 0.1) for _ in range(2))
    mask = np.arange(6) % 2 == 0
    one.rest(mask)
    for _ in range(5):
        qpos = rng.uniform(ROBOT.lower, ROBOT.upper, (6, ROBOT.dof))
        for mine, theirs in zip(one.drive(qpos, 0.1), other.drive(qpos, 0.1), strict=True):
            assert_array_equal(mine[~mask], theirs[~mask])
    one.rest(np.zeros(6, bool))
    for mine, theirs in zip(one.read(), other.read(), strict=True):
        assert_array_equal(mine, theirs)


def test_arms_that_rest_are_not_computed():
    """They stay where they were."""
    simulation = IdealSimulator().open(ROBOT, 2, 0.1)
    stood = simulation.read().end_effector
    simulation.rest(np.array([True, False]))
    moved = simulation.drive(np.tile(ROBOT.home + 0.1, (2, 1)), 0.1).end_effector
    assert (moved[0] == stood[0]).all()
    assert (moved[1] != stood[1]).any()
