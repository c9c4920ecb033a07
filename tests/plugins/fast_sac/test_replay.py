"""The replay buffer."""

import numpy as np
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

from harness_plugins.fast_sac.training import Replay

OBSERVATION, ACTION = 3, 2


def filled(capacity, numbers, envs=1):
    """A buffer in which transition i is told by i; those with an odd number are terminated."""
    replay = Replay(capacity, OBSERVATION, ACTION)
    for start in range(0, len(numbers), envs):
        n = np.array(numbers[start : start + envs], np.float32)[:, np.newaxis]
        ones = np.ones((len(n), OBSERVATION), np.float32)
        replay.add(n * ones, 0.1 * n * ones[:, :ACTION], (n + 0.5) * ones, 100.0 * n[:, 0], n[:, 0] % 2 == 1)
    return replay


def test_a_transition_comes_back_as_it_went_in():
    """Action, observation and a 1 before it; the same after it, the action still empty; reward; whether it ends."""
    batch = filled(10, [3]).draw(4, default_rng(0))
    before, after = batch.inputs
    assert_allclose(before, np.tile([0.3, 0.3, 3.0, 3.0, 3.0, 1.0], (4, 1)), rtol=1e-6)
    assert_allclose(after, np.tile([0.0, 0.0, 3.5, 3.5, 3.5, 1.0], (4, 1)), rtol=1e-6)
    assert batch.reward.tolist() == [300.0] * 4
    assert batch.goes_on.tolist() == [0.0] * 4


def test_parts_of_a_batch_belong_together():
    """Reward, end and observation of each row are those of one transition."""
    batch = filled(10, range(10)).draw(200, default_rng(0))
    numbers = batch.inputs[0][:, -2]
    assert_array_equal(batch.reward, 100.0 * numbers)
    assert_array_equal(batch.inputs[1][:, -2], numbers + 0.5)
    assert_array_equal(batch.goes_on, numbers % 2 == 0)


def test_only_what_was_added_is_drawn():
    """A buffer that is not full has nothing in the rest of it."""
    replay = filled(1_000, [7, 8, 9])
    assert replay.size == 3
    assert set(replay.draw(200, default_rng(0)).inputs[0][:, -2]) == {7.0, 8.0, 9.0}


def test_every_transition_is_drawn_as_often():
    """Uniform: 10,000 draws of 10."""
    drawn = filled(10, range(10)).draw(10_000, default_rng(0)).inputs[0][:, -2]
    assert abs(np.bincount(drawn.astype(int), minlength=10) - 1_000).max() < 150


def test_the_oldest_are_forgotten():
    """Also where several envs add over the end of the buffer at once."""
    for envs in (1, 3, 4):
        replay = filled(5, range(12), envs)
        assert replay.size == 5
        assert set(replay.draw(200, default_rng(0)).inputs[0][:, -2]) == {7.0, 8.0, 9.0, 10.0, 11.0}


def test_writing_over_a_batch_leaves_the_buffer_alone():
    """The next draw finds the actions that were taken."""
    replay = filled(10, [3])
    batch = replay.draw(4, default_rng(0))
    batch.inputs[...] = -1.0
    assert_allclose(replay.draw(4, default_rng(0)).inputs[0][:, 0], 0.3, rtol=1e-6)
