"""Rewards inside rewards: what it costs to name them."""

import importlib

import pytest

from harness import load_registry
from harness.registry.choice import choose

NEST = """
import harness
from pydantic.dataclasses import dataclass
from harness.authoring.wrapped_reward import WrappedReward

loads, builds = [], []

@harness.hookimpl
def register_rewards(register):
    loads.append("rewards")
    register("egg", __name__ + ":Egg", summary="inside all others")
    for name in ("A", "B", "C", "D", "E"):
        register(name.lower(), __name__ + ":" + name, summary="takes one in")

@dataclass(frozen=True)
class Egg:
    def __post_init__(self):
        builds.append("egg")

    def initial_carry(self, begin_distance):
        return ()

    def __call__(self, carry, sample):
        return carry, sample.distance

@dataclass(frozen=True)
class A(WrappedReward):
    registered_name = "a"
    def __post_init__(self):
        builds.append(self.registered_name)

    def __call__(self, carry, sample):
        return self._reward(carry, sample)

@dataclass(frozen=True)
class B(A):
    registered_name = "b"

@dataclass(frozen=True)
class C(A):
    registered_name = "c"

@dataclass(frozen=True)
class D(A):
    registered_name = "d"

@dataclass(frozen=True)
class E(A):
    registered_name = "e"
"""


@pytest.fixture
def nest(install):
    """An installed package of rewards that take one another in, and count how often they are loaded and built."""
    return importlib.import_module(install("nest", NEST))


def _nested(depth):
    """``egg``, ``a:reward=(egg)``, ``b:reward=(a:reward=(egg))``."""
    return "egg" if depth == 0 else f"{'abcde'[depth - 1]}:reward=({_nested(depth - 1)})"


def test_naming_a_reward_inside_a_reward_loads_no_plugin_again(nest):
    """Neither to resolve two levels nor to build them: the registry at hand is handed inwards."""
    registry = load_registry()
    nest.loads.clear()
    choice = choose(registry, "rewards", _nested(2))
    built = choice.build(registry, "rewards")
    assert nest.loads == []
    assert (choice.label, type(built.named.named).__name__) == ("b:reward=a:reward=egg", "Egg")


def test_reward_built_by_hand_loads_the_plugins(nest):
    """Once, however deep: whoever writes Python has no registry to hand in. It shows that the count counts."""
    built = nest.B(_nested(1))
    assert nest.loads == ["rewards"]
    assert built == choose(load_registry(), "rewards", _nested(2)).build(load_registry(), "rewards")


@pytest.mark.parametrize("depth", range(6))
def test_every_level_is_built_once(nest, depth):
    """To resolve a name and to build it: what it costs grows with the depth, and no faster."""
    registry = load_registry()
    levels = sorted(["egg", *"abcde"[:depth]])
    choice = choose(registry, "rewards", _nested(depth))
    assert sorted(nest.builds) == levels
    nest.builds.clear()
    choice.build(registry, "rewards")
    assert sorted(nest.builds) == levels


def test_deep_name_has_the_label_that_gives_it_again(nest):
    """With parameters of its own on the way."""
    registry = load_registry()
    choice = choose(registry, "rewards", "scaled:factor=4,reward=b:reward=(a:reward=(arp:k1=2,k2=3))")
    assert choice.label == "scaled:reward=(b:reward=(a:reward=(arp:k1=2,k2=3))),factor=4"
    assert choose(registry, "rewards", choice.label) == choice
