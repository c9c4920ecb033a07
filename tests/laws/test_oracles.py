"""What is said of synthetic experiments of which the truth is known."""

import pytest

from tests.laws.oracles import KINDS, Tally, tally

SOME = 7
"""The quick run takes every so many."""
FALSE, APART = 0.05, 0.6
"""The most of equal rewards of which a difference is claimed, and the most points between two logs of one training."""
FOUND = {"+6": 75 / 135, "+12": 108 / 135}
"""Of how many whole experiments a difference of so many points was found before values were compared over steps."""


@pytest.fixture(scope="module", params=[pytest.param(1, marks=pytest.mark.slow), SOME])
def found(request):
    """What is said of experiments of a kind."""
    return lambda kind: tally(kind, range(0, KINDS[kind], request.param))


def test_few_false_words_are_said(found):
    """Of trainings by two equal rewards, logged on grids of their own, that have learned, or are learning still."""
    said = Tally("equal", [it for kind in ("learned", "learning") for it in found(kind).oracles])
    assert said.share() <= FALSE, said.sentence


def test_differences_are_found(found):
    """Of 6 and of 12 points; where trainings stopped halfway nothing is claimed."""
    for kind, least in FOUND.items():
        said = found(kind)
        assert (said.share() >= least, said.share(stopped=2)) == (True, 0.0), said.sentence


def test_trainings_that_are_logged_in_two_ways_are_equal(found):
    """Nothing is claimed of the same trainings on two grids, and no share differs."""
    said = found("exact")
    assert (said.claims, said.farthest <= APART) == ([], True), said.sentence


def test_a_word_does_not_depend_on_the_way_of_logging(found):
    """Both rewards are logged in one way, and then in another; a log without an end may say less."""
    said = found("twice")
    assert not said.differing, said.sentence
