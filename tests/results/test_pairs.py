"""Pairs of episodes, counted by how both ended."""

from itertools import product

import pytest

from harness.results.pairs import BOTH, FIRST, NEITHER, SECOND, Met, Pairs, kind_of, kinds_of
from harness.results.replay import choose, shows_of

KINDS = kinds_of("reach", "arp", "es")


def pairs_of(*kinds, differs=()):
    """Pairs of one seed."""
    gaps = differs or (0.0,) * len(kinds)
    return Pairs(KINDS, tuple(Met(0, at, kind, gap) for at, (kind, gap) in enumerate(zip(kinds, gaps, strict=True))))


def test_each_way_to_end_has_its_words():
    """Both sides, either, none: four kinds, and the words name who succeeds."""
    told = {(one, other): KINDS[kind_of(one, other)] for one, other in product([True, False], repeat=2)}
    assert told == {
        (True, True): "both reach",
        (True, False): "only the baseline reaches",
        (False, True): "only arp reaches",
        (False, False): "neither reaches",
    }


def test_the_most_frequent_kind_is_first_and_its_share_is_said():
    """Also where a rarer kind comes first; of equally frequent ones the order of the kinds decides."""
    pairs = pairs_of(FIRST, BOTH, BOTH, SECOND)
    assert [pairs.share(kind) for kind in pairs.counts] == [
        "both reach: 2 of 4 pairs",
        "only the baseline reaches: 1 of 4 pairs",
        "only arp reaches: 1 of 4 pairs",
    ]
    assert pairs.otherwise == "2 of 4 end otherwise"


def test_where_all_end_alike_none_ends_otherwise():
    """Nothing is said of what does not occur."""
    pairs = pairs_of(NEITHER, NEITHER)
    assert (list(pairs.counts), pairs.otherwise) == ([NEITHER], "")


@pytest.mark.parametrize(
    ("differs", "middle"), [((3.0, 1.0, 2.0), 2), ((4.0, 1.0, 2.0, 3.0), 2), ((1.0, 1.0, 1.0), 1)], ids=str
)
def test_the_typical_pair_is_the_middle_one(differs, middle):
    """Of its kind alone, by how much both differ; the lower of two middle ones, the middle of equal ones."""
    pairs = pairs_of(*[BOTH] * len(differs), SECOND, differs=(*differs, 0.0))
    assert pairs.typical(BOTH) == middle
    assert pairs.typical(SECOND) == len(differs)


def test_typical_pairs_are_chosen_before_others():
    """Of each kind, the most frequent one first; then an episode of each outcome; every pair once."""
    kinds = [BOTH] * 5 + [FIRST, BOTH, NEITHER]
    ends = [["reached"] * 7 + ["ground"], ["reached"] * 5 + ["time-out", "reached", "time-out"]]
    chosen = choose(ends, pairs_of(*kinds))
    assert chosen[:4] == [2, 5, 7, 0]
    assert sorted(chosen) == list(range(8))


def test_pairs_of_an_arm_are_those_of_its_recorded_ends(recorded):
    """Counted anew from the episodes that are shown, which here are all."""
    (show,) = shows_of(recorded)
    assert show.pairs is not None
    ends = zip(*([it.outcome == "reached" for it in side.episodes] for side in show.sides), strict=True)
    assert [it.kind for it in show.pairs.met] == [kind_of(*both) for both in ends]
    assert show.kinds[show.pairs.usual] == show.first
