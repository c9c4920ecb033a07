"""Objects where names are expected."""

import dataclasses
import sys

import pytest

from harness import load_registry
from harness.experiment.objects import name_objects
from harness.registry import choose
from harness_plugins.environments.any_gymnasium import AnyGymnasium
from harness_plugins.rewards.arp import Arp
from tests.refusals import refused


@dataclasses.dataclass(frozen=True)
class Steps:
    """Pays each step."""

    k: float = 1.0

    def initial_carry(self, begin_distance):
        """Nothing."""
        return ()

    def __call__(self, carry, sample):
        """The same always."""
        return carry, self.k + 0.0 * sample.distance


@pytest.fixture
def importable(monkeypatch):
    """As if this module were one that anybody can import."""
    monkeypatch.setitem(sys.modules, Steps.__module__, sys.modules[__name__])
    return Steps


def test_names_stay_names():
    """And what takes no objects stays as it is."""
    given = {"sim": "a,b", "algo": ["sac", {"name": "ppo"}], "seeds": [1, 2], "robot": None}
    assert name_objects(given) == (given, ())


def test_object_of_a_registered_class_has_its_name():
    """With all parameters; the class need not be sent."""
    named, classes = name_objects({"reward": [Arp(k2=2.0), "dense"]})
    assert named["reward"][0] == {"name": "arp", **dataclasses.asdict(Arp(k2=2.0))}
    assert (named["reward"][1], classes) == ("dense", ())


def test_object_of_another_class_is_named_by_its_module(importable):
    """A registry that knows the class builds the same object."""
    named, classes = name_objects({"reward": importable(k=3.0)})
    registry = load_registry(given=classes)
    choice = choose(registry, "rewards", named["reward"])
    assert choice.name == f"{importable.__module__}/Steps"
    assert choice.label.endswith("/Steps:k=3")
    assert choice.build(registry, "rewards") == importable(k=3.0)


@pytest.mark.parametrize("given", [lambda carry, sample: 0.0, Steps, object()])
def test_what_is_no_object_of_a_dataclass_is_refused(given):
    """In one line that says what to give."""
    with refused("give a name, or an object of a dataclass with initial_carry, __call__"):
        name_objects({"reward": given})


def test_object_of_another_kind_is_refused():
    """A reward is no simulator."""
    with refused("Arp has no open; a simulator has open"):
        name_objects({"sim": Arp()})


def test_an_environment_may_stand_for_a_task():
    """An object of a registered environment has the plugin's name."""
    named, classes = name_objects({"task": AnyGymnasium("Pendulum-v1", lower="speed")})
    assert named["task"]["name"] == "gymnasium"
    assert (named["task"]["id"], named["task"]["lower"]) == ("Pendulum-v1", "speed")
    assert classes == ()
