"""Recorded runs scored by a reward, or why they cannot be."""

import numpy as np
import pytest

from harness.errors import Unscored
from harness.record import trace_of
from harness.registry import Choice, choose, load_registry
from harness.score import InstalledReward, pay_log


@pytest.fixture(scope="module")
def registry():
    """The installed plugins."""
    return load_registry()


@pytest.fixture
def run():
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
    return trace_of({**columns, **flags})


def _paid(run, reward, registry):
    return trace_of({**run.rows().columns, "reward": pay_log(reward.build(registry, "rewards"), run).total})


GONE = Choice("gone", (), "gone")


@pytest.fixture(name="arp")
def _arp(registry):
    return InstalledReward(choose(registry, "rewards", "arp"), registry)


def test_runs_are_paid(run, arp, registry):
    """As the reward pays them."""
    np.testing.assert_array_equal(arp.pay(run, arp.choice).total, _paid(run, arp.choice, registry)["reward"])


def test_reward_pays_what_it_paid(run, arp, registry):
    """It has not changed since."""
    assert arp.pays_recorded(_paid(run, arp.choice, registry))


def test_reward_that_has_changed_says_so(run, arp):
    """It does not pay what is recorded."""
    pays = arp.pays_recorded(run)
    assert not pays
    with pytest.raises(Unscored, match="reward arp now pays its recorded steps differently: it has changed"):
        arp.require_unchanged(pays)


def test_reward_that_is_gone_says_so(run, registry):
    """With the message of the registry."""
    with pytest.raises(Unscored, match=r"^No reward 'gone'"):
        InstalledReward(GONE, registry).pay(run, GONE)


def test_reward_that_is_gone_has_no_fingerprint(registry):
    """Nothing that was kept of runs by another reward can be looked for."""
    with pytest.raises(Unscored, match=r"^No reward 'gone'"):
        InstalledReward(GONE, registry).fingerprint(Choice("arp", (), "arp"))


def test_reward_that_is_gone_pays_its_own_run_from_columns(run, registry):
    """What its terms paid is recorded, and other weights are a factor."""
    terms = {"reward/near": np.array([0.0, 1.0, 2.0, 3.0]), "reward/calm": np.full(4, 0.5)}
    own = trace_of({**run.rows().columns, **terms})
    heavier = InstalledReward(Choice("gone", (("near", 2.0), ("calm", 1.0)), "gone:near=2"), registry)
    paid = heavier.pay(own, Choice("gone", (("near", 1.0), ("calm", 1.0)), "gone"))
    np.testing.assert_array_equal(paid.terms["near"], [0.0, 2.0, 4.0, 6.0])
    np.testing.assert_array_equal(paid.total, [0.5, 2.5, 4.5, 6.5])


def test_reward_that_is_gone_does_not_pay_the_run_of_another(run, registry):
    """Their columns are of other terms."""
    own = trace_of({**run.rows().columns, "reward/near": np.ones(4)})
    with pytest.raises(Unscored, match=r"^No reward 'gone'"):
        InstalledReward(GONE, registry).pay(own, Choice("other", (), "other"))


def test_parameters_are_in_the_fingerprint(registry):
    """`arp:k2=2` pays otherwise than `arp`."""
    rewards = [InstalledReward(choose(registry, "rewards", text), registry) for text in ("arp", "arp:k2=2")]
    assert len({it.fingerprint(GONE) for it in rewards}) == 2
