"""The floors: whatever is observed, anything is done."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

from harness.policy import Uniform, UniformChoice

FLOORS = pytest.mark.parametrize("floor", [Uniform((-1.0, 0.0), (1.0, 4.0)), UniformChoice(5)])


@pytest.mark.parametrize("seed", [None, 0])
def test_actions_fill_the_box_evenly(observations, seed):
    """Each tenth of the box holds a tenth of the actions; drawn or scattered, they are not told apart."""
    rng = None if seed is None else default_rng(seed)
    actions = Uniform((-1.0, 0.0), (1.0, 4.0)).act(observations(5000), rng)
    for column, ends in zip(actions.T, ((-1.0, 1.0), (0.0, 4.0)), strict=True):
        assert_allclose(np.histogram(column, 10, ends)[0] / 5000, 0.1, atol=0.02)
    assert abs(np.corrcoef(actions.T)[0, 1]) < 0.05


@pytest.mark.parametrize("seed", [None, 0])
def test_every_choice_comes_equally_often(observations, seed):
    """A fifth each; drawn or scattered."""
    rng = None if seed is None else default_rng(seed)
    choices = UniformChoice(5).act(observations(5000), rng)
    assert choices.dtype == np.int64
    assert_allclose(np.bincount(choices, minlength=5) / 5000, 0.2, atol=0.02)


@FLOORS
def test_without_a_generator_an_action_belongs_to_its_observation(floor, observations):
    """NOTE eq. 36: the same alone, in a batch, in another order, asked again."""
    seen = observations(6)
    actions = floor.act(seen)
    assert_array_equal(floor.act(seen[::-1])[::-1], actions)
    assert_array_equal(np.concatenate([floor.act(row[None]) for row in seen]), actions)


@FLOORS
def test_zero_has_no_sign(floor):
    """Observations that are equal are acted on alike."""
    zero = np.zeros((1, 3), np.float32)
    assert_array_equal(floor.act(-zero), floor.act(zero))


@FLOORS
def test_no_env_is_no_action(floor):
    """A batch of none gives none, in the usual shape."""
    some, none = (floor.act(np.zeros((count, 3), np.float32)) for count in (1, 0))
    assert (none.shape, none.dtype) == ((0, *some.shape[1:]), some.dtype)


@given(st.integers(0, 100), st.floats(-10, 10, width=32), st.floats(-10, 10, width=32), st.booleans())
def test_actions_stay_in_the_box(observations, seed, low, high, is_drawn):
    """Bounds included."""
    low, high = sorted((low, high))
    actions = Uniform((low,), (high,)).act(observations(), default_rng(seed) if is_drawn else None)
    assert (actions >= np.float32(low)).all()
    assert (actions <= np.float32(high)).all()
