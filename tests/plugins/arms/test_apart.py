"""Arms in worlds of their own: who is told what, and what the batch remembers."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from harness_plugins.arms.apart import ArmsApart
from tests.registered import FD100 as ROBOT

HOME = np.tile(ROBOT.home, (3, 1))


class SlowArm:
    """Does nine tenths of what it is told, and writes down all of it."""

    def __init__(self):
        self.told = []

    def put(self, qpos):
        """At rest there."""
        self.qpos, self.qvel = qpos.copy(), np.zeros_like(qpos)
        self.told.append("put")

    def turn(self, speeds, duration):
        """Too slowly."""
        self.qvel = 0.9 * speeds
        self.qpos = self.qpos + self.qvel * duration
        self.told.append("turn")

    def read(self, state, env):
        """Touches the ground where its first joint is turned back."""
        state.qpos[env], state.qvel[env] = self.qpos, self.qvel
        state.end_effector[env], state.ground_contact[env] = env, self.qpos[0] < 0.0


@pytest.fixture
def simulation():
    """Three of them."""
    return ArmsApart(ROBOT, 3, SlowArm)


def test_arms_begin_at_home(simulation):
    """Each in its own row."""
    state = simulation.read()
    assert_array_equal(state.qpos, HOME)
    assert_array_equal(state.end_effector, [[0.0] * 3, [1.0] * 3, [2.0] * 3])


def test_what_is_missed_in_a_period_is_made_up_for_in_the_next(simulation):
    """The speed leads from where the joint is: a tenth of the way is left, then a hundredth."""
    left = [np.abs(HOME + 1.0 - simulation.drive(HOME + 1.0, 0.1).qpos).max() for _ in range(3)]
    assert_allclose(left, [0.1, 0.01, 0.001])
    assert_allclose(simulation.read().qvel, 0.9 * 0.01 / 0.1)


def test_reset_is_for_those_in_the_mask(simulation):
    """The others are told nothing."""
    simulation.reset(HOME - 1.0, np.array([False, True, False]))
    assert [len(arm.told) for arm in simulation.arms] == [1, 2, 1]
    assert simulation.read().ground_contact.tolist() == [False, True, False]


def test_resting_arms_are_left_alone_until_they_are_reset(simulation):
    """They cost nothing."""
    one = np.array([True, False, False])
    simulation.rest(one)
    simulation.drive(HOME + 0.1, 0.1)
    assert [arm.told[-1] for arm in simulation.arms] == ["put", "turn", "turn"]
    simulation.reset(HOME, one)
    simulation.drive(HOME + 0.1, 0.1)
    assert simulation.arms[0].told == ["put", "put", "turn"]


def test_frame_shows_the_arm_and_changes_nothing(simulation):
    """Drawn by the harness, in the size asked for."""
    pytest.importorskip("PIL")
    first = simulation.render(0, np.array([0.5, 0.0, 0.5]), 64, 48)
    simulation.place(HOME + 0.5)
    assert first.shape == (48, 64, 3)
    assert (simulation.render(0, np.array([0.5, 0.0, 0.5]), 64, 48) != first).any()
    assert_array_equal(simulation.read().qpos, HOME + 0.5)


def test_close_lets_the_arms_go(simulation):
    """A second call does nothing."""
    simulation.close()
    simulation.close()
    assert simulation.arms == []
