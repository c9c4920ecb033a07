"""Actions of Unity's agents as spaces."""

import numpy as np
import pytest
from gymnasium.spaces import Box, Discrete
from hypothesis import given, strategies as st

from harness_plugins.unity_player.actions import MOST_CHOICES, action_space, to_unity
from harness_plugins.unity_player.messages import Behaviour, UnityError


def behaviour(continuous=0, *branches):
    """One that observes a number."""
    return Behaviour("Arm", (1,), ("",), continuous, branches)


def test_continuous_actions_are_a_box():
    """Each in [-1, 1], as ML-Agents clips them."""
    assert action_space(behaviour(3)) == Box(-1.0, 1.0, (3,), np.float32)


def test_a_branch_is_a_choice():
    """Of as many."""
    assert action_space(behaviour(0, 4)) == Discrete(4)


def test_branches_are_the_choice_of_a_combination():
    """All combinations."""
    assert action_space(behaviour(0, 3, 2)) == Discrete(6)


@given(st.lists(st.integers(1, 5), min_size=1, max_size=4))
def test_every_combination_is_chosen_once(branches):
    """No two choices do the same, and each is within its branch."""
    it = behaviour(0, *branches)
    chosen = [tuple(to_unity(it, choice)[1]) for choice in range(int(np.prod(branches)))]
    assert len(set(chosen)) == len(chosen)
    assert all(0 <= part < size for each in chosen for part, size in zip(each, branches, strict=True))


def test_continuous_actions_stay_within_their_bounds():
    """Unity's own are clipped there too."""
    assert to_unity(behaviour(2), [3.0, -0.5]) == ([1.0, -0.5], [])


@pytest.mark.parametrize(
    ("it", "told"),
    [
        (behaviour(2, 3), "2 continuous actions and 1 discrete branches"),
        (behaviour(), "0 discrete branches"),
        (behaviour(0, MOST_CHOICES, 2), "2,048 combinations"),
    ],
)
def test_other_actions_are_refused(it, told):
    """The message names the behaviour."""
    with pytest.raises(UnityError, match=f"'Arm' .*{told}"):
        action_space(it)
