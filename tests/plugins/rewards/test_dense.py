"""The negative distance."""

import math

import pytest
from hypothesis import given, strategies as st

from harness.registry import build
from harness_plugins.rewards.dense import Dense
from tests.plugins.rewards.distances import DISTANCES
from tests.refusals import refused


@pytest.mark.parametrize(("scale", "distance", "expected"), [(1.0, 0.25, -0.25), (2.0, 1.5, -3.0), (1.0, 0.0, 0.0)])
def test_value_by_hand(episode, scale, distance, expected):
    """-scale d(t)."""
    assert episode(Dense(scale), [1.0, distance]) == [expected]


def test_example_1_of_the_note(episode):
    """|(1,1,2) - (0.5,-1,2)| = sqrt(4.25), as a distance to a target."""
    assert episode(Dense(), [3.0, math.dist((1, 1, 2), (0.5, -1, 2))]) == [-math.sqrt(4.25)]


@given(DISTANCES, st.floats(0.01, 10.0))
def test_bounds(episode, distances, scale):
    """Between minus scale times the largest distance and 0."""
    values = episode(Dense(scale), distances)
    assert (values <= 0.0).all()
    assert (values >= -scale * max(distances)).all()


def test_scale_is_positive():
    """Paying for distance is refused."""
    with refused("scale=-1: Input should be greater than 0"):
        build(Dense, {"scale": -1}, "reward 'dense'")
