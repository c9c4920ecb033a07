"""A null control: another reward times a constant."""

import pytest
from hypothesis import given, settings, strategies as st
from numpy.testing import assert_array_equal

import harness
from harness.registry import choose
from harness_plugins.kit import check_contract
from harness_plugins.rewards.aarp import Aarp
from harness_plugins.rewards.arp import Arp
from harness_plugins.rewards.scaled import Scaled
from tests.refusals import refused
from tests.registered import REGISTRY

OTHERS = [name for name in REGISTRY.names("rewards") if name != "scaled"]
DISTANCES = st.lists(st.floats(0.0, 3.0), min_size=2, max_size=20)


@pytest.mark.parametrize("reward", OTHERS)
def test_contract(reward):
    """It keeps the contract of rewards, whatever it multiplies."""
    check_contract("reward", Scaled(reward=reward, factor=1.25))


@pytest.mark.parametrize("reward", OTHERS)
def test_factor_of_one_changes_nothing(episode, reward):
    """It pays what the named reward pays, bit for bit."""
    named, same = choose(REGISTRY, "rewards", reward).build(REGISTRY, "rewards"), Scaled(reward=reward, factor=1.0)

    @given(DISTANCES)
    def holds(distances):
        assert_array_equal(episode(same, distances), episode(named, distances))

    holds()


@settings(max_examples=25)  # each looks all plugins up
@given(DISTANCES, st.floats(0.01, 100.0))
def test_value_is_multiplied(episode, distances, factor):
    """Every step pays `factor` times as much, of a reward with a carry too."""
    reward = Scaled(reward="aarp:growth=2", factor=factor)
    assert_array_equal(episode(reward, distances), factor * episode(Aarp(growth=2.0), distances))


@pytest.mark.parametrize(
    ("text", "label"),
    [
        ("scaled", "scaled"),
        ("scaled:reward=arp:k2=2,factor=3", "scaled:reward=arp:k2=2,factor=3"),
        ("scaled:factor=3,reward=arp:k2=2", "scaled:reward=arp:k2=2,factor=3"),
        ("scaled:reward=arp:k1=2,k2=3,factor=4", "scaled:reward=(arp:k1=2,k2=3),factor=4"),
        ("scaled:reward=(arp:k1=2,k2=3),factor=4", "scaled:reward=(arp:k1=2,k2=3),factor=4"),
        ("scaled:reward=shifted:reward=arp:k2=2", "scaled:reward=shifted:reward=arp:k2=2"),
        ("scaled:reward=(shifted:reward=(arp:k1=2,k2=3),offset=1)",) * 2,
    ],
)
def test_any_reward_is_named_with_its_parameters(text, label):
    """The label, typed again, is the same choice."""
    choice = choose(REGISTRY, "rewards", text)
    assert choice.label == label
    assert choose(REGISTRY, "rewards", label) == choice


def test_one_reward_is_named_by_one_text():
    """However the named reward is typed, the parameter says it in one way: one choice, one cell."""
    texts = ["arp", "arp:k2=1.5", " arp : k1 = 1 , k2 = 1.50 "]
    assert len({Scaled(reward=text) for text in texts}) == 1
    assert len({choose(REGISTRY, "rewards", {"name": "scaled", "reward": text}) for text in texts}) == 1


def test_named_reward_is_built_once():
    """At construction, with its parameters."""
    scaled = Scaled(reward="arp:k1=2,k2=3")
    assert scaled.named == Arp(k1=2.0, k2=3.0)
    assert scaled.named is scaled.named


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("scaled:reward=apr", "No reward 'apr'. There is: .* Did you mean 'arp'"),
        ("scaled:reward=arp:k3=1", "Reward 'arp' has no parameter 'k3'"),
        ("scaled:reward=arp:k2=0", "Reward 'arp': k2='0': Input should be greater than 0"),
        ("scaled:reward=arp:k2", "'arp:k2' is malformed"),
        ("scaled:reward=(arp:k1=2,k2=3,factor=4", "is malformed"),
        ("scaled:factor=0", "Reward 'scaled': factor='0': Input should be greater than 0"),
        ("scaled:reward=arp:k2=2,factor=inf", "Reward 'scaled': factor='inf': Input should be a finite number"),
        ("scaled:reward=scaled", "Reward 'scaled' is given 'scaled': it cannot stand inside itself"),
        ("scaled:reward=shifted:reward=scaled:factor=2", "'scaled' .* cannot stand inside itself"),
        ("scaled:" + "reward=scaled:" * 500 + "factor=2", "'scaled' .* cannot stand inside itself"),
        ("scaled:" + "reward=scaled:" * 5000 + "factor=2", "has 70,015 characters, 10,000 are allowed"),
    ],
)
def test_what_cannot_be_named_is_refused_at_once(text, message):
    """In one line, when it is typed, before anything runs."""
    with refused(message):
        harness.make_env(reward=text)
