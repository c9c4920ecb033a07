"""What episodes brought while a policy learned."""

import numpy as np

from harness_plugins.episode_means import EpisodeMeans


def test_means_of_the_episodes_that_ended():
    """Each env counts for itself, from its last end on."""
    means = EpisodeMeans(2)
    means.watch(np.array([1.0, 10.0]), np.array([False, True]))
    means.watch(np.array([2.0, 20.0]), np.array([True, False]))
    means.watch(np.array([4.0, 40.0]), np.array([False, True]))
    told = means.take()
    assert told["Environment/Cumulative Reward"] == (10.0 + 3.0 + 60.0) / 3
    assert told["Environment/Episode Length"] == (1 + 2 + 2) / 3


def test_what_was_taken_is_not_told_again():
    """Nothing is told where no episode ended since."""
    means = EpisodeMeans(1)
    means.watch(np.array([1.0]), np.array([True]))
    assert means.take()
    means.watch(np.array([1.0]), np.array([False]))
    assert means.take() == {}


def test_means_go_on_as_they_would_have():
    """Episodes that ended and were not told yet, and those under way."""
    first, second = EpisodeMeans(2), EpisodeMeans(2)
    first.watch(np.array([1.0, 2.0]), np.array([True, False]))
    second.restore(first.state())
    for means in (first, second):
        means.watch(np.array([3.0, 4.0]), np.array([False, True]))
    assert first.take() == second.take()
    assert first.take() == second.take() == {}
