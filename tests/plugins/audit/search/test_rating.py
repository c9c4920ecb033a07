"""Where chance decides, a certificate holds a policy: its held-out episodes are played again and compared."""

from dataclasses import replace

import numpy as np
import pytest
from gymnasium.spaces import Discrete
from numpy.random import default_rng
from scipy import stats

from harness_plugins.audit import read_certificate, write_certificate
from harness_plugins.audit.search.behaviour import Rated
from harness_plugins.audit.search.replay import certify, rating_of, replay
from harness_plugins.audit.search.world import Outcomes
from tests.plugins.audit.search.certified import RUNS_ON, Line, certificate_of, finding_of, place_of

POLICY = {"kind": "table", "choices": {"0": 1}}
STARTS = tuple(range(1_000_000, 1_000_030))


class Coin(Line):
    """Pays 1 for a choice of 1 with a chance that seeds tell, or that nothing tells."""

    space = Discrete(2)

    def __init__(self, chance=0.7, seed=None):
        super().__init__()
        self.chance, self.rng = chance, default_rng(seed) if seed else None

    def act(self, starts, policy):
        """An episode of a step for each start."""
        draws = [(self.rng or default_rng(int(start))).random() for start in starts]
        paid = np.array([float(draw < self.chance) * policy(0) for draw in draws])
        ones = np.ones(len(starts), np.int64)
        return Outcomes(ones, paid, paid, paid > 0, ones, paid, paid), [np.array([1])] * len(starts)


def certified(world):
    """A certificate of the policy in a world."""
    of, _ = world.act(STARTS, lambda seen: 1)
    return certificate_of(policy=POLICY, rating=rating_of(of, STARTS))


def test_seeded_chance_is_the_same_bit_for_bit(tmp_path):
    """From the file; the line has the interval."""
    write_certificate(certified(Coin()), tmp_path / "c.json")
    found = replay(read_certificate(tmp_path / "c.json"), Coin())
    paid = np.array(found.found.rating["paid"], float)
    mean, (low, high) = paid.mean(), stats.t.interval(0.95, len(paid) - 1, paid.mean(), stats.sem(paid))
    assert not found.is_refused
    told = f"the same: {mean:.3g} [{low:.3g}, {high:.3g}] an episode on 30 held-out starts, success {mean:.0%}"
    assert found.lines[0] == told


def test_unseeded_chance_is_about_the_same():
    """Two samples of one chance."""
    found = replay(certified(Coin(seed=1)), Coin(seed=2))
    assert not found.is_refused
    assert found.lines[0].startswith("about the same: ")
    assert "; the file says " in found.lines[0]


def test_another_chance_is_refused():
    """By Welch's test; the reasons are told."""
    found = replay(certified(Coin(seed=1)), Coin(0.1, seed=2), ["numpy is 3 here, and was 2."])
    assert found.is_refused
    assert found.lines[0].startswith("NOT THE SAME, refused. number ")
    assert found.lines[1] == "numpy is 3 here, and was 2."
    assert found.to_json()["same"] is False


@pytest.mark.parametrize(
    ("one", "other", "same"), [([1, 1], [1, 1], True), ([1, 1], [2, 2], False), ([0, 1, 0, 1], [1, 0, 1, 0], True)]
)
def test_what_agrees(one, other, same):
    """Equal ones, also where nothing varies; without a warning."""
    world, then = Coin(), {"starts": list(range(len(one))), "paid": one, "success": one}
    found, ones = np.array(other), np.ones(len(other), np.int64)
    world.act = lambda *_: (Outcomes(ones, found, found, found > 0, ones, found, found), [])
    again = replay(certificate_of(policy=POLICY, rating=then), world, ["numpy is 3 here, and was 2."])
    assert again.is_refused is not same


def test_a_policy_is_certified_by_its_figures():
    """Of a fresh world; one whose figures are others there is not certified, and the reason is told."""
    finding = finding_of(Line())
    outcomes, actions = Coin().act(STARTS, lambda seen: 1)
    rated = Rated(POLICY, STARTS, outcomes, actions[0])
    three = {"failure": replace(finding.three["failure"], policy=POLICY)}
    chance = replace(
        finding,
        three=three,
        shown={"failure": finding.shown["failure"]},
        searched=replace(finding.searched, rates=dict.fromkeys(("paid", "discounted", "random"), rated)),
    )
    (made,), refused = certify(chance, place_of(), Coin, RUNS_ON, seed=0, budget=9)
    assert refused == []
    assert made.policy == POLICY
    assert made.rating["paid"] == outcomes.paid.tolist()
    made, refused = certify(chance, place_of(), lambda: Coin(0.05), RUNS_ON, seed=0, budget=9)
    assert made == []
    assert refused[0].startswith("near, failure: not certified. Played again, ")
