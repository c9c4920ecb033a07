"""Exact tests, against every way written out in loops."""

import itertools
from math import comb

import numpy as np
import pytest
from hypothesis import example, given, strategies as st
from hypothesis.extra.numpy import arrays
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

from harness.eta import corrected_p, p_of, swaps_of
from harness.eta.swaps import corrected_where_known, label_shares

LATTICE = st.integers(-20, 20).map(lambda count: count / 20)
DIFFERENCES = st.lists(LATTICE | st.floats(-10.0, 10.0).map(lambda value: round(value, 3)), min_size=1, max_size=8)
CLAIMS = st.tuples(st.integers(1, 6), st.integers(2, 6)).flatmap(lambda shape: arrays(float, shape, elements=LATTICE))
NOISE = 1e-9


def outcomes_of(differences):
    """The mean difference in all ways."""
    values = np.asarray(differences, float)
    return swaps_of(range(len(values))).signs @ values / len(values)


def slow_p(differences):
    """All 2^n ways to give each difference a sign."""
    seen = abs(sum(differences))
    ways = list(itertools.product([1.0, -1.0], repeat=len(differences)))
    reached = [way for way in ways if abs(sum(s * d for s, d in zip(way, differences, strict=True))) >= seen - NOISE]
    return len(reached) / len(ways)


def slow_corrected(outcomes):
    """Westfall and Young (1993), algorithm 2.8, with sizes in units of each claim's root mean square."""
    sizes = []
    for claim in outcomes:
        spread = (sum(value**2 for value in claim) / len(claim)) ** 0.5
        sizes.append([abs(value) / spread if spread else 0.0 for value in claim])
    order = sorted(range(len(sizes)), key=lambda claim: -sizes[claim][0])
    corrected, before = [0.0] * len(sizes), 0.0
    for rank, claim in enumerate(order):
        count = 0
        for way in range(len(sizes[claim])):
            largest = max(sizes[other][way] for other in order[rank:])
            count += largest >= sizes[claim][0] - NOISE
        before = max(before, count / len(sizes[claim]))
        corrected[claim] = before
    return corrected


# Ways


@pytest.mark.parametrize("seeds", [0, 1, 2, 6, 13])
def test_all_ways_of_few_seeds(seeds):
    """Each once, but for the sign of all; the first keeps every name."""
    signs = swaps_of(range(seeds)).signs
    assert signs.shape == (2 ** max(0, seeds - 1), seeds)
    assert (np.abs(signs) == 1.0).all()
    assert (signs[0] == 1.0).all()
    assert len({tuple(way) for way in np.concatenate([signs, -signs]).tolist()}) == 2**seeds


def test_many_seeds_have_drawn_ways():
    """As many as 4_096, the first keeps every name, each seed is swapped in half of them, the same each time."""
    signs = swaps_of(range(20)).signs
    assert signs.shape == (4_096, 20)
    assert (signs[0] == 1.0).all()
    assert_allclose(signs.mean(axis=0), 0.0, atol=0.08)
    assert_array_equal(signs, swaps_of(range(20)).signs)


def test_seeds_are_swapped_by_their_name():
    """A comparison of some seeds swaps those, whatever their place."""
    swaps = swaps_of([3, 5, 8])
    assert_array_equal(swaps.of([8, 3]), swaps.signs[:, [2, 0]])


@given(DIFFERENCES)
def test_comparison_of_some_seeds_is_exact_too(differences):
    """The ways of more seeds hold every way of these equally often."""
    count = len(differences)
    assert p_of(swaps_of(range(count + 2)).of(range(1, count + 1)) @ np.array(differences)) == slow_p(differences)


# One claim


@given(DIFFERENCES)
@example([1.0, 2.0, 3.0])
@example([0.1, 0.2, -0.3])
@example([0.7, 0.1, -0.8, 0.0])
def test_p_counts_all_ways(differences):
    """As a loop over all of them does, also where a sum of floats is 0 but for its last bit; alone it is corrected."""
    outcomes = outcomes_of(differences)
    assert [p_of(outcomes)] == [slow_p(differences)] == corrected_p([outcomes])


# Several claims


@given(CLAIMS)
def test_corrected_p_is_westfall_and_youngs(claims):
    """The procedure as it is taught, in loops."""
    outcomes = [outcomes_of(claim) for claim in claims]
    assert corrected_p(outcomes) == pytest.approx(slow_corrected([claim.tolist() for claim in outcomes]), abs=1e-12)


def test_nothing_is_corrected_without_a_claim():
    """And nothing fails."""
    assert corrected_p([]) == []


def test_claims_of_which_nothing_is_known_are_left_out():
    """They have no p-value, and the others have those that they have without them."""
    one, other = outcomes_of([1.0] * 8), outcomes_of([1.0, -0.5] * 4)
    first, second = corrected_p([one, other])
    assert corrected_where_known([None, one, None, other]) == [None, first, None, second]


# Shares of runs


def test_labels_are_dealt_out_anew():
    """The first row is as it was; in every other each side has its number of runs, all runs come into each side."""
    shares = label_shares(4, 6)
    assert shares.shape == (4_096, 10)
    assert_allclose(shares[0], [-0.25] * 4 + [1.0 / 6.0] * 6)
    assert_array_equal(np.sort(shares, axis=1), np.sort(np.tile(shares[0], (4_096, 1)), axis=1))
    assert_allclose((shares > 0.0).mean(axis=0), 0.6, atol=0.04)
    assert_array_equal(shares, label_shares(4, 6))


def test_p_of_dealt_labels_is_that_of_all_ways():
    """Of 4 and 5 runs there are 126 ways: as a loop over them, within 5 standard errors of the drawn ones."""
    rng = default_rng(5)
    values = np.concatenate([rng.normal(size=4), rng.normal(2.0, size=5)])
    seen, reached = values[4:].mean() - values[:4].mean(), 0
    for side in itertools.combinations(range(9), 5):
        rest = [run for run in range(9) if run not in side]
        reached += abs(values[list(side)].mean() - values[rest].mean()) >= abs(seen) - NOISE
    exact = reached / comb(9, 5)
    assert 0.005 < exact < 0.5
    assert p_of(label_shares(4, 5) @ values) == pytest.approx(exact, abs=5.0 * (exact / 4_096) ** 0.5)
