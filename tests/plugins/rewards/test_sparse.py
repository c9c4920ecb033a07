"""Nothing is shaped."""

from hypothesis import given, strategies as st
from numpy.testing import assert_array_equal

from harness_plugins.rewards.sparse import Sparse


@given(st.lists(st.floats(0.0, 3.0), min_size=2, max_size=30))
def test_every_step_pays_nothing(episode, distances):
    """0, whatever happens."""
    assert_array_equal(episode(Sparse(), distances), 0.0)
