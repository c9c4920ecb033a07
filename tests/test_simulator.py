"""Which engine a simulator computes with."""

from typing import ClassVar

import pytest

from harness.env.vector_env import World
from harness.simulator import family_of
from tests.heavy_arms import Heavy
from tests.registered import REGISTRY

FAMILIES = {
    "dm_control": "MuJoCo", "drake": "Drake", "kinematic": None, "mjx": "MuJoCo", "mujoco": "MuJoCo",
    "physx": "PhysX", "pybullet": "Bullet",
}  # fmt: skip


class Unnamed:
    """Says nothing of its engine."""


class Named(Unnamed):
    """Says it."""

    family: ClassVar[str] = "Bullet"


def test_family_is_the_same_for_a_class_and_what_is_built_of_it():
    """It is the class that has it."""
    assert family_of(Named) == family_of(Named()) == "Bullet"


def test_simulator_that_names_none_is_a_family_of_its_own():
    """By the name of its class."""
    assert family_of(Unnamed()) == "Unnamed"


@pytest.mark.parametrize("simulator", FAMILIES)
def test_built_in_simulators_name_their_engine(installed, simulator):
    """In the class, and in the line that is listed without importing it."""
    spec = REGISTRY.get("simulators", simulator)
    family = family_of(spec.load())
    assert family == FAMILIES[simulator]
    assert (f"engine {family}" if family else "no engine") in spec.summary


class Heavier(Heavy):
    """One arm takes more than there is for all."""

    arm_bytes = 8 * Heavy.arm_bytes


@pytest.mark.parametrize(
    ("simulator", "most", "ends"),
    [
        (Named, None, [7]),
        (Named, 4, [4, 7]),
        (Heavy, None, [3, 6, 7]),
        (Heavy, 2, [2, 4, 6, 7]),
        (Heavy, 256, [3, 6, 7]),
        (Heavier, None, [1, 2, 3, 4, 5, 6, 7]),
    ],
)
def test_arms_that_cost_much_are_held_in_batches(simulator, most, ends):
    """Each arm is in one of them, in order; those that cost little are held together."""
    found = World(simulator(), None, None, None).batches(7, most)
    assert found == list(map(slice, [0, *ends], ends))
