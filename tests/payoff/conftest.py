"""Rollouts of the scripted policies without an engine, and rewards whose properties are known."""

from dataclasses import dataclass

import numpy as np
import pytest

from harness.payoff.rollout import record_rollouts
from harness.registry import choose
from harness.task import ReachTask
from harness_plugins.kit import IdealSimulator
from tests.registered import FD100, REGISTRY


@dataclass(frozen=True)
class Paying:
    """Pays what a function of the sample says; remembers nothing."""

    value: object

    def initial_carry(self, begin_distance):
        """Nothing."""
        return ()

    def __call__(self, carry, sample):
        """Ask the function."""
        return carry, self.value(sample)


@dataclass(frozen=True)
class Counting:
    """Pays the number of steps so far that came nearer: what it remembers has no end."""

    def initial_carry(self, begin_distance):
        """None so far."""
        return np.zeros_like(begin_distance)

    def __call__(self, carry, sample):
        """One more where it is nearer."""
        count = carry + (sample.distance < sample.previous_distance)
        return count, count


def named(name):
    """A registered reward."""
    return choose(REGISTRY, "rewards", name).build(REGISTRY, "rewards")


def potential(gamma, phi=lambda distance: -distance):
    """Shaping by the potential `phi` of the distance."""
    return Paying(lambda sample: gamma * phi(sample.distance) - phi(sample.previous_distance))


def relative_gain(sample):
    """Share of the larger distance gained: bounded and scale-free."""
    larger = np.maximum(sample.previous_distance, sample.distance)
    return (sample.previous_distance - sample.distance) / np.where(larger > 0.0, larger, 1.0)


DENSE, RELATIVE = Paying(lambda sample: -sample.distance), Paying(relative_gain)
BASELINE, ARP = named("baseline"), named("arp")


@pytest.fixture(scope="session")
def robot():
    """The FD100."""
    return FD100


@pytest.fixture(scope="session")
def task():
    """The FD100's task."""
    return ReachTask()


@pytest.fixture(scope="session")
def rollouts(robot, task):
    """Twelve episodes of each script, by an arm that moves exactly as told."""
    return record_rollouts(IdealSimulator(), robot, task, 12)


@pytest.fixture(scope="session")
def by_script(rollouts):
    """The same by name."""
    return {rollout.script: rollout for rollout in rollouts}
