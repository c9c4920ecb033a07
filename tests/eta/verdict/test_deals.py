"""Labels dealt anew: all ways there are, or many drawn ones."""

import math

import numpy as np
import pytest

from harness.eta.verdict.deals import MOST_DEALS, count_deals, deals_of, smallest_p

SECOND, LAST = "00011100111101010001", "01010010100100011111"


def test_all_ways_are_tried_where_there_are_few():
    """Three trainings each: 6 choose 3, every one once."""
    deals = deals_of(((0, 3, 3),))
    assert deals.shape == (20, 6)
    assert len(np.unique(deals, axis=0)) == 20


def test_the_first_way_is_as_they_were_trained():
    """Baselines first, then the proposed reward's, in each stratum."""
    assert deals_of(((0, 2, 2), (1, 3, 3)))[0].tolist() == [0, 0, 1, 1, 0, 0, 0, 1, 1, 1]


@pytest.mark.parametrize("strata", [((0, 4, 4),), ((0, 2, 2), (1, 3, 1)), ((0, 20, 8),), ((0, 3, 0), (1, 3, 3))])
def test_a_stratum_keeps_its_labels(strata):
    """As many of each reward as were trained in it."""
    deals, begin = deals_of(strata), 0
    for _, baselines, proposed in strata:
        end = begin + baselines + proposed
        assert (deals[:, begin:end].sum(axis=1) == proposed).all()
        begin = end


def test_unequal_numbers_are_dealt_in_all_ways():
    """Three of the proposed reward among five: 5 choose 3."""
    deals = deals_of(((0, 2, 3),))
    assert deals.shape == (10, 5)
    assert len(np.unique(deals, axis=0)) == 10
    assert deals[0].tolist() == [0, 0, 1, 1, 1]


@pytest.mark.parametrize(("baselines", "proposed"), [(3, 0), (0, 2)])
def test_a_stratum_of_one_side_has_one_way(baselines, proposed):
    """There is nothing to swap."""
    assert count_deals(((0, baselines, proposed),)) == 1
    assert deals_of(((0, baselines, proposed),)).tolist() == [[0.0] * baselines + [1.0] * proposed]


def test_drawn_ways_of_equal_numbers_are_those_that_reports_have_always_had():
    """The labels of the second and the last way for ten of each, as they were before unequal numbers came."""
    deals = deals_of(((0, 10, 10),))
    assert "".join(str(int(label)) for label in deals[1]) == SECOND
    assert "".join(str(int(label)) for label in deals[-1]) == LAST


def test_many_ways_are_drawn():
    """Of 10 seeds there are 184,756."""
    assert count_deals(((0, 10, 10),)) == math.comb(20, 10)
    assert len(deals_of(((0, 10, 10),))) == MOST_DEALS


def test_drawn_ways_are_the_same_in_every_report():
    """For equal strata, whatever else was asked before."""
    first = deals_of(((7, 12, 12),)).copy()
    for name in range(20):
        deals_of(((name, 11, 11),))
    assert (deals_of(((7, 12, 12),)) == first).all()


def test_drawn_ways_of_a_stratum_stay_when_others_come_behind_it():
    """So that a deal keeps its labels from look to look."""
    one, both = deals_of(((0, 6, 6),), is_drawn=True), deals_of(((0, 6, 6), (1000, 4, 4)), is_drawn=True)
    assert (both[:, :12] == one).all()


def test_deals_cannot_be_written_to():
    """They are shared."""
    with pytest.raises(ValueError, match="read-only"):
        deals_of(((0, 3, 3),))[0, 0] = 1.0


@pytest.mark.parametrize(("seeds", "p"), [(3, 0.1), (4, 2 / 70), (5, 2 / 252)])
def test_the_smallest_p_is_that_of_the_two_most_extreme_ways(seeds, p):
    """Four seeds are the fewest that can show anything at 0.05."""
    assert smallest_p(seeds, seeds) == pytest.approx(p)


def test_the_smallest_p_of_many_seeds_is_that_of_the_drawn_ways():
    """One of 20,000."""
    assert smallest_p(20, 20) == 1 / MOST_DEALS
    assert smallest_p(1000, 1000) == 1 / MOST_DEALS  # there are more ways than a float can say


@pytest.mark.parametrize(("baselines", "proposed"), [(10, 5), (3, 6), (2, 2)])
def test_the_smallest_p_of_unequal_numbers_is_that_of_the_single_most_extreme_way(baselines, proposed):
    """All labels swapped are another experiment there: the proposed reward would have the baseline's trainings."""
    ways = count_deals(((0, baselines, proposed),))
    smallest = 2 / ways if baselines == proposed else 1 / ways
    assert smallest_p(baselines, proposed) == pytest.approx(smallest)
