"""Which engine a simulator computes with."""

from typing import ClassVar

import pytest

from harness.env.vector_env import ARMS_BYTES, World
from harness.registry import load_registry
from harness.simulator import family_of

REGISTRY = load_registry()
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


@pytest.mark.parametrize(
    ("arms", "most", "cost", "sizes"),
    [
        (9, None, 0, [9]),
        (9, 4, 0, [4, 4, 1]),
        (9, None, ARMS_BYTES // 3, [3, 3, 3]),
        (8, 2, ARMS_BYTES // 3, [2, 2, 2, 2]),
        (2, 256, ARMS_BYTES // 3, [2]),
        (2, None, 2 * ARMS_BYTES, [1, 1]),
    ],
)
def test_arms_that_cost_much_are_held_in_batches(arms, most, cost, sizes):
    """Each arm is in one of them, in order; those that cost little are held together."""

    class Costly(Named):
        arm_bytes: ClassVar[int] = cost

    found = World(Costly() if cost else Named(), None, None, None).batches(arms, most)
    assert [it.stop - it.start for it in found] == sizes
    assert [k for it in found for k in range(arms)[it]] == list(range(arms))
