"""ARP with a gain that accelerates itself."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.testing import assert_array_equal

from harness.registry import build
from harness.reward import Sample
from harness_plugins.rewards.aarp import Aarp
from harness_plugins.rewards.arp import Arp
from tests.plugins.rewards.distances import DISTANCES, GAINS
from tests.refusals import refused

DOUBLING = Aarp(k1=1.0, k2=1.0, growth=2.0, k_max=4.0)


def test_values_by_hand(episode):
    """The gain doubles with each new best up to 4, and is 1 again after a step without one."""
    distances = [1.0, 0.875, 0.75, 0.625, 0.75, 0.5, 0.5, 0.25]
    gained = [2 * 0.125, 4 * 0.25, 4 * 0.375, -0.125, 2 * 0.5, 1 * 0.5, 2 * 0.75]
    assert episode(DOUBLING, distances).tolist() == gained


@given(GAINS, GAINS, DISTANCES)
def test_without_growth_it_is_arp(episode, k1, k2, distances):
    """A growth of 1 pays every step as `arp`, bit for bit."""
    plain = episode(Arp(k1=k1, k2=k2), distances)
    assert_array_equal(episode(Aarp(k1=k1, k2=k2, growth=1.0, k_max=10.0), distances), plain)


@given(DISTANCES, st.floats(1.0, 3.0))
def test_gain_is_the_closed_formula(episode, distances, growth):
    """K = min(k2 growth^n, k_max), n the length of the row of improvements that ends here."""
    best, row, expected = distances[0], 0, []
    for distance in distances[1:]:
        row = row + 1 if distance < best else 0
        gain = min(1.5 * growth**row, 4.0)
        expected.append(best - distance if distance > best else gain * (distances[0] - distance))
        best = min(best, distance)
    assert episode(Aarp(growth=growth, k_max=4.0), distances) == pytest.approx(np.array(expected), rel=1e-12)


@given(DISTANCES)
def test_bounds(episode, distances):
    """-k1 d(t) <= r <= k_max Bd, and never less than ARP pays."""
    values = episode(Aarp(k1=2.0, k2=1.5, growth=1.5, k_max=3.0), distances)
    assert (values <= 3.0 * distances[0]).all()
    assert (values >= -2.0 * np.array(distances[1:])).all()
    assert (values >= episode(Arp(k1=2.0, k2=1.5), distances)).all()


def test_a_long_row_stays_bounded(episode):
    """After ten thousand improvements the gain is k_max, and nothing has overflowed."""
    assert episode(Aarp(growth=10.0), np.linspace(1.0, 0.0, 10_001))[-1] == 3.0


def test_carry_is_the_gain_and_is_written_anew():
    """One float per env; what was handed in is left as it was."""
    carry = DOUBLING.initial_carry(np.array([1.0, 1.0, 1.0]))
    one, best = np.ones(3), np.array([1.0, 1.0, 0.5])
    distance = np.array([0.5, 1.0, 0.75])
    after, _ = DOUBLING(carry, Sample(one, best, best, distance, distance - best, one))
    assert carry.tolist() == [1.0, 1.0, 1.0]
    assert after.tolist() == [2.0, 1.0, 1.0]


def test_cap_below_the_gain_is_refused():
    """The gain cannot begin above its largest value."""
    with refused("Reward 'aarp': k_max=3 should be at least k2=5"):
        build(Aarp, {"k2": 5}, "reward 'aarp'")


@pytest.mark.parametrize("given", [{"growth": 0.9}, {"k1": 0}, {"k_max": "inf"}])
def test_parameter_out_of_range_is_refused(given):
    """In one line that names it."""
    with refused(f"Reward 'aarp': {next(iter(given))}="):
        build(Aarp, given, "reward 'aarp'")
