"""Potential-based shaping, Ng, Harada and Russell 1999."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.testing import assert_array_equal

from harness.registry import build
from harness_plugins.algorithms.sac import Sac
from harness_plugins.kit import check_contract
from harness_plugins.rewards.potential import Potential
from tests.refusals import refused

METRES = st.integers(0, 3072).map(lambda n: n / 1024)
DISTANCES = st.lists(METRES, min_size=2, max_size=30)
GAMMAS = st.floats(0.01, 1.0)


def test_contract():
    """It keeps the contract of rewards, discounted or not."""
    check_contract("reward", Potential())
    check_contract("reward", Potential(gamma=1.0, scale=3.0))


def test_value_by_hand(episode, subtests):
    """Paid is scale (d(t-1) - gamma d(t))."""
    rows = [
        (1.0, 1.0, 1.0, 0.75, 0.25),  # nearer
        (1.0, 1.0, 0.75, 1.0, -0.25),  # farther
        (0.5, 1.0, 1.0, 1.0, 0.5),  # standing still pays (1 - gamma) d
        (0.5, 2.0, 1.0, 0.5, 1.5),
        (0.5, 1.0, 1.0, 0.0, 1.0),  # onto the target
        (0.5, 1.0, 0.0, 0.0, 0.0),  # standing on it
    ]
    for gamma, scale, before, after, expected in rows:
        with subtests.test(gamma=gamma, scale=scale, before=before, after=after, expected=expected):
            assert episode(Potential(gamma, scale), [2.0, before, after])[-1] == expected


def test_example_2_of_the_note(episode):
    """Without a discount, from sqrt(6.25) to sqrt(4.25) is paid their difference."""
    assert episode(Potential(gamma=1.0), [math.sqrt(6.25), math.sqrt(4.25)]) == [math.sqrt(6.25) - math.sqrt(4.25)]


@given(DISTANCES, GAMMAS, st.floats(0.01, 10.0))
def test_discounted_sum_telescopes(episode, distances, gamma, scale):
    """Over an episode it is gamma^T phi(T) - phi(0), whatever lies between."""
    values = episode(Potential(gamma, scale), distances)
    total = (gamma ** np.arange(len(values)) * values).sum()
    assert total == pytest.approx(scale * (distances[0] - gamma ** len(values) * distances[-1]), abs=1e-9)


@given(DISTANCES, GAMMAS)
def test_bounds(episode, distances, gamma):
    """-gamma scale d(t) <= F <= scale d(t-1)."""
    values = episode(Potential(gamma, scale=2.0), distances)
    assert (values <= 2.0 * np.array(distances[:-1])).all()
    assert (values >= -2.0 * gamma * np.array(distances[1:]) - 1e-12).all()


@given(DISTANCES, st.sampled_from([0.25, 2.0, 64.0]))
def test_scaling_the_workspace_scales_the_reward(episode, distances, factor):
    """So does the parameter scale, by as much."""
    values = factor * episode(Potential(), distances)
    assert_array_equal(episode(Potential(), [factor * distance for distance in distances]), values)
    assert_array_equal(episode(Potential(scale=factor), distances), values)


def test_discount_is_that_of_the_default_learner():
    """What the docstring says of `sac`."""
    assert Potential().gamma == Sac().gamma


@pytest.mark.parametrize("gamma", [0, 1.01])
def test_discount_out_of_range_is_refused(gamma):
    """In one line that names it."""
    with refused(f"gamma={gamma}: Input should be "):
        build(Potential, {"gamma": gamma}, "reward 'potential'")
