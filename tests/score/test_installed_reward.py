"""Recorded runs scored by a reward, or why they cannot be."""

import numpy as np
import pytest

from harness.errors import Unscored
from harness.log import trace_of
from harness.registry import Choice, choose
from harness.score.installed_reward import InstalledReward
from harness.score.scorer import pay_log


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


GONE = Choice("gone", (), "gone")


@pytest.fixture(name="arp")
def _arp(registry):
    return InstalledReward(choose(registry, "rewards", "arp"), registry)


def test_reward_pays_what_it_paid(run, arp, registry):
    """It has not changed since."""
    paid = arp.pay(run, arp.choice).total
    np.testing.assert_array_equal(paid, pay_log(arp.choice.build(registry, "rewards"), run).total)
    assert arp.pays_recorded(trace_of({**run.rows().columns, "reward": paid}))


def test_reward_that_has_changed_is_told(run, arp):
    """It does not pay what is recorded."""
    assert not arp.pays_recorded(run)


def test_reward_that_is_gone_says_so(run, registry):
    """With the message of the registry: columns of another's terms do not pay, and nothing that was kept is found."""
    own, gone = trace_of({**run.rows().columns, "reward/near": np.ones(4)}), InstalledReward(GONE, registry)
    other = Choice("other", (), "other")
    for ask in (lambda: gone.pay(run, GONE), lambda: gone.pay(own, other), lambda: gone.fingerprint(other)):
        with pytest.raises(Unscored, match=r"^No reward 'gone'"):
            ask()


def test_reward_that_is_gone_pays_its_own_run_from_columns(run, registry):
    """What its terms paid is recorded, and other weights are a factor."""
    terms = {"reward/near": np.array([0.0, 1.0, 2.0, 3.0]), "reward/calm": np.full(4, 0.5)}
    own = trace_of({**run.rows().columns, **terms})
    heavier = InstalledReward(Choice("gone", (("near", 2.0), ("calm", 1.0)), "gone:near=2"), registry)
    paid = heavier.pay(own, Choice("gone", (("near", 1.0), ("calm", 1.0)), "gone"))
    np.testing.assert_array_equal(paid.terms["near"], [0.0, 2.0, 4.0, 6.0])
    np.testing.assert_array_equal(paid.total, [0.5, 2.5, 4.5, 6.5])


def test_parameters_are_in_the_fingerprint(registry):
    """`arp:k2=2` pays otherwise than `arp`."""
    rewards = [InstalledReward(choose(registry, "rewards", text), registry) for text in ("arp", "arp:k2=2")]
    assert len({it.fingerprint(GONE) for it in rewards}) == 2
