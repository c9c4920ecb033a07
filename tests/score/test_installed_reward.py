"""Recorded runs scored by a reward, or why they cannot be."""

import numpy as np
import pytest

from harness.errors import Unscored
from harness.record.trace import Trace
from harness.registry.choice import Choice, choose
from harness.registry.registry import Registry, load_registry
from harness.score.installed_reward import InstalledReward
from harness.score.scorer import score_trace


@pytest.fixture(scope="module")
def registry() -> Registry:
    """The installed plugins."""
    return load_registry()


@pytest.fixture
def run() -> Trace:
    """One episode whose rewards nobody has filled in."""
    distance = np.array([1.0, 1.5, 0.5, 0.25])
    flags = dict.fromkeys(("reached", "terminated", "truncated"), np.zeros(4, bool))
    columns = {
        "env": np.zeros(4, int),
        "step": np.arange(4),
        "begin_distance": np.ones(4),
        "previous_best": np.array([1.0, 1.0, 1.0, 0.5]),
        "distance": distance,
        "reward": np.zeros(4),
    }
    return Trace({**columns, **flags})


def _paid(run: Trace, reward: Choice, registry: Registry) -> Trace:
    return Trace({**run.columns, "reward": score_trace(reward.build(registry, "rewards"), run)})


@pytest.fixture(name="arp")
def _arp(registry: Registry) -> InstalledReward:
    return InstalledReward(choose(registry, "rewards", "arp"), registry)


def test_runs_are_paid(run: Trace, arp: InstalledReward, registry: Registry):
    """As the reward pays them."""
    np.testing.assert_array_equal(arp.pay(run), _paid(run, arp.choice, registry)["reward"])


def test_reward_pays_what_it_paid(run: Trace, arp: InstalledReward, registry: Registry):
    """It has not changed since."""
    assert arp.pays_recorded(_paid(run, arp.choice, registry))


def test_reward_that_has_changed_says_so(run: Trace, arp: InstalledReward):
    """It does not pay what is recorded."""
    pays = arp.pays_recorded(run)
    assert not pays
    with pytest.raises(Unscored, match="reward arp now pays its recorded steps differently: it has changed"):
        arp.require_unchanged(pays)


def test_reward_that_is_gone_says_so(run: Trace, registry: Registry):
    """With the message of the registry."""
    with pytest.raises(Unscored, match=r"^No reward 'gone'"):
        InstalledReward(Choice("gone", (), "gone"), registry).pay(run)


def test_reward_that_is_gone_has_no_fingerprint(registry: Registry):
    """Nothing that was kept can be looked for."""
    with pytest.raises(Unscored, match=r"^No reward 'gone'"):
        _ = InstalledReward(Choice("gone", (), "gone"), registry).fingerprint


def test_parameters_are_in_the_fingerprint(registry: Registry):
    """`arp:k2=2` pays otherwise than `arp`."""
    prints = {InstalledReward(choose(registry, "rewards", text), registry).fingerprint for text in ("arp", "arp:k2=2")}
    assert len(prints) == 2
