"""A null control: another reward plus a constant."""

import pytest
from hypothesis import given, settings, strategies as st
from numpy.testing import assert_array_equal

from harness.registry import choose
from harness_plugins.rewards.aarp import Aarp
from harness_plugins.rewards.shifted import Shifted
from tests.plugins.rewards.test_scaled import DISTANCES
from tests.refusals import refused
from tests.registered import REGISTRY

OTHERS = [name for name in REGISTRY.names("rewards") if name != "shifted"]


@settings(max_examples=25)  # each looks all plugins up
@given(DISTANCES, st.floats(-10.0, 10.0))
def test_value_is_moved(episode, distances, offset):
    """Every step pays `offset` more, of a reward with a carry too."""
    reward = Shifted(reward="aarp:growth=2", offset=offset)
    assert_array_equal(episode(reward, distances), episode(Aarp(growth=2.0), distances) + offset)


def test_offset_of_zero_changes_nothing(episode, subtests):
    """It pays what the named reward pays."""
    for reward in OTHERS:
        with subtests.test(reward=reward):
            named, same = (
                choose(REGISTRY, "rewards", reward).build(REGISTRY, "rewards"),
                Shifted(reward=reward, offset=0.0),
            )
            distances = [1.0, 0.5, 0.75, 0.25, 0.25, 0.0, 1.5]
            assert_array_equal(episode(same, distances), episode(named, distances))


def test_named_reward_comes_with_its_parameters():
    """`shifted:reward=arp:k1=2,k2=3,offset=1` on the command line is the table of a file."""
    typed = choose(REGISTRY, "rewards", "shifted:reward=arp:k1=2,k2=3,offset=1")
    assert typed.params == (("reward", "arp:k1=2,k2=3"), ("offset", 1.0))
    assert typed == choose(REGISTRY, "rewards", {"name": "shifted", "reward": "arp:k1=2,k2=3", "offset": 1})
    assert typed == choose(REGISTRY, "rewards", typed.label)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("shifted:reward=apr", "No reward 'apr'"),
        ("shifted:offset=nan", "Reward 'shifted': offset='nan': Input should be a finite number"),
        ("shifted:reward=scaled:reward=shifted", "'shifted' .* cannot stand inside itself"),
    ],
)
def test_what_cannot_be_named_is_refused_at_once(text, message):
    """In one line, when it is typed."""
    with refused(message):
        choose(REGISTRY, "rewards", text)
