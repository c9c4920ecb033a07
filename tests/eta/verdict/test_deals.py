"""Labels dealt anew: all ways there are, or many drawn ones."""

import math

import numpy as np
import pytest

from harness.eta.verdict.deals import count_deals, deals_of

SECOND, LAST = "00011100111101010001", "01010010100100011111"


@pytest.mark.parametrize(
    ("strata", "ways"),
    [(((0, 3, 3),), 20), (((0, 2, 3),), 10), (((0, 2, 2), (1, 3, 3)), 120), (((0, 3, 0),), 1), (((0, 0, 2),), 1)],
)
def test_all_ways_are_tried_where_there_are_few(strata, ways):
    """Every one once, the first as they were trained: in each stratum baselines, then the proposed reward's."""
    deals = deals_of(strata)
    assert len(deals) == len(np.unique(deals, axis=0)) == count_deals(strata) == ways
    assert deals[0].tolist() == [label for _, ours, theirs in strata for label in [0] * ours + [1] * theirs]


@pytest.mark.parametrize("strata", [((0, 4, 4),), ((0, 2, 2), (1, 3, 1)), ((0, 20, 8),), ((0, 3, 0), (1, 3, 3))])
def test_a_stratum_keeps_its_labels(strata):
    """As many of each reward as were trained in it."""
    deals, begin = deals_of(strata), 0
    for _, baselines, proposed in strata:
        end = begin + baselines + proposed
        assert (deals[:, begin:end].sum(axis=1) == proposed).all()
        begin = end


def test_drawn_ways_of_equal_numbers_are_those_that_reports_have_always_had():
    """Of 184,756 the labels of the second and the last drawn way for ten of each, as before unequal numbers came."""
    deals = deals_of(((0, 10, 10),))
    assert (count_deals(((0, 10, 10),)), len(deals)) == (math.comb(20, 10), 20_000)
    assert ["".join(str(int(label)) for label in deals[at]) for at in (1, -1)] == [SECOND, LAST]


def test_drawn_ways_are_the_same_in_every_report():
    """For equal strata, whatever else was asked before."""
    first = deals_of(((7, 12, 12),)).copy()
    for name in range(20):
        deals_of(((name, 11, 11),))
    assert (deals_of(((7, 12, 12),)) == first).all()


def test_deals_cannot_be_written_to():
    """They are shared."""
    with pytest.raises(ValueError, match="read-only"):
        deals_of(((0, 3, 3),))[0, 0] = 1.0
