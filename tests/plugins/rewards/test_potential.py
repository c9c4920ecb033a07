"""Potential-based shaping, Ng, Harada and Russell 1999."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

from harness.registry import build
from harness_plugins.algorithms.sac import Sac
from harness_plugins.rewards.potential import Potential
from tests.plugins.rewards.distances import DISTANCES
from tests.refusals import refused

GAMMAS = st.floats(0.01, 1.0)


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


def test_discount_is_that_of_the_default_learner():
    """What the docstring says of `sac`."""
    assert Potential().gamma == Sac().gamma


@pytest.mark.parametrize("gamma", [0, 1.01])
def test_discount_out_of_range_is_refused(gamma):
    """In one line that names it."""
    with refused(f"gamma={gamma}: Input should be "):
        build(Potential, {"gamma": gamma}, "reward 'potential'")
