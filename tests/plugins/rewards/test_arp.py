"""ARP, "K2": the baseline with a gain on each half."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

import harness
from harness.reward import Sample
from harness_plugins.rewards.arp import Arp
from harness_plugins.rewards.baseline import Baseline
from tests.plugins.rewards.distances import GAINS
from tests.refusals import refused

METRES = st.floats(0.0, 3.0)


def pay(reward, begin, best, distance):
    """The shaped reward of a step of one env."""
    parts = (begin, best, best, distance, distance - best, 1.0)
    _, value = reward(reward.initial_carry(np.array([begin])), Sample(*(np.array([part]) for part in parts)))
    return float(value[0])


def test_value_by_hand(subtests):
    """Dd > 0: -k1 Dd. Dd <= 0: k2 (Bd - d)."""
    rows = [
        (1.0, 1.5, 1.0, 1.0, 0.75, 0.375),  # nearer: k2 (Bd - d)
        (1.0, 2.0, 1.0, 0.5, 0.25, 1.5),  # a new best: k2 times all that was gained since the start
        (2.0, 1.5, 1.0, 0.5, 0.75, -0.5),  # farther than the best: -k1 Dd
        (3.0, 2.0, 1.0, 1.0, 1.5, -1.5),  # farther than the start
        (9.0, 2.0, 1.0, 0.5, 0.5, 1.0),  # Dd = 0 counts as gained
        (1.0, 1.5, 1.0, 1.0, 1.0, 0.0),  # standing still at the start
    ]
    for k1, k2, begin, best, distance, expected in rows:
        with subtests.test(k1=k1, k2=k2, begin=begin, best=best, distance=distance, expected=expected):
            assert pay(Arp(k1=k1, k2=k2), begin, best, distance) == expected


@given(METRES, METRES, METRES)
def test_gains_of_one_are_the_baseline(begin, best, distance):
    """With k1 = k2 = 1 every step is paid, bit for bit, as under the baseline."""
    assert pay(Arp(k1=1.0, k2=1.0), begin, best, distance) == pay(Baseline(), begin, best, distance)


@given(GAINS, GAINS, METRES, METRES, METRES)
def test_each_gain_scales_its_half(k1, k2, begin, best, distance):
    """A step is paid k1 times the baseline where the best is missed, and k2 times elsewhere."""
    gain = k1 if distance - best > 0.0 else k2
    expected = gain * pay(Baseline(), begin, best, distance)
    assert pay(Arp(k1=k1, k2=k2), begin, best, distance) == pytest.approx(expected, rel=1e-12, abs=0.0)


def test_defaults_are_those_of_the_published_data():
    """Left alone, k1 is 1 and k2 is 1.5."""
    assert Arp() == Arp(k1=1.0, k2=1.5)


def test_nothing_is_carried():
    """The carry is empty."""
    assert Arp().initial_carry(np.ones(3)) == ()


def test_bad_gain_is_a_usage_error(subtests):
    """A gain that is not a positive number is refused, in one line that names it."""
    for gain in ["k1=0", "k2=0", "k1=-1", "k2=much", "k2=nan", "k2=inf", "k3=1"]:
        with subtests.test(gain=gain), refused(gain[:2]):
            harness.make_env(reward=f"arp:{gain}")
