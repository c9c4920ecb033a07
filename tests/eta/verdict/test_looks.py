"""A question that is asked several times, while seeds come in."""

from dataclasses import replace

import numpy as np
import pytest

from harness.eta import Looks, Question, rule, rule_in_looks
from harness.eta.verdict.looks import ONE_PLACE, SEVERAL_PLACES, check_looks, looks_for
from tests.eta.scenarios import values_of

LOOKS = Looks((4, 6, 8, 12))


def ruled(effect=0.0, spread=1.0, seed=0, looks=LOOKS, complete=None, ends=(-9.0, 19.0)):
    """What is said of normal values in one place at so many complete looks; by default at all."""
    values = spread * values_of(looks.seeds[-1], seed=seed)
    values[1] += effect
    at = np.searchsorted(looks.seeds, np.arange(looks.seeds[-1]), side="right")[:, None]
    question = Question.of(values, np.array([[ends]]))
    return rule_in_looks(question, at, looks, len(looks.seeds) if complete is None else complete)


def test_nothing_is_said_before_the_first_look():
    """And nothing is over."""
    found = ruled(9.0, complete=0)
    assert (found.p, found.is_over) == (None, False)


def test_a_large_effect_ends_at_an_early_look():
    """Later seeds are not asked for."""
    found = ruled(15.0)
    assert found.is_decided
    assert found.look < 3
    assert found.sign == 1


def test_the_answer_of_a_look_stands_when_more_seeds_come():
    """What was trained beside it changes nothing."""
    answers = [ruled(12.0, complete=complete) for complete in range(1, 5)]
    first = next(at for at, it in enumerate(answers) if it.is_decided)
    assert all(it == answers[first] for it in answers[first:])


def test_the_last_look_ends_it():
    """Whatever is found; there alone labels are dealt anew."""
    looks = replace(LOOKS, margin=0.001)
    found = ruled(seed=1, looks=looks)
    assert found.is_last
    assert found.is_over
    assert not found.is_decided
    assert found.p is not None
    assert ruled(seed=1, looks=looks, complete=3).p is None


def test_the_last_look_ends_it_though_hardly_any_training_left_a_value():
    """Else a run would wait for trainings that nobody planned."""
    values = np.full((2, 6, 1, 1), np.nan)
    values[:, 0] = 1.0
    question = Question.of(values, np.array([[(0.0, 1.0)]]), np.ones((2, 6, 1), bool))
    at = np.array([0, 0, 0, 0, 1, 1])[:, None]
    ends = [rule_in_looks(question, at, Looks((4, 6)), complete).is_over for complete in (1, 2)]
    assert ends == [False, True]


def test_at_the_last_look_these_trainings_may_differ_all_the_same():
    """Without known ends there is no plain word; the p is that of all trainings at once."""
    found = ruled(3.0, ends=(-np.inf, np.inf))
    values = values_of(12)
    values[1] += 3.0
    (at_once,) = rule([Question.of(values)])
    assert found.is_ahead
    assert found.p == at_once.p


def test_from_the_second_look_on_the_bound_is_wider():
    """98 in place of 95 %, shared by all questions."""
    assert ruled(complete=1).confidence == pytest.approx(0.95)
    assert ruled(complete=2).confidence == pytest.approx(0.98)
    assert ruled(complete=2, looks=replace(LOOKS, asked=4)).confidence == pytest.approx(0.995)


def test_a_small_difference_ends_it():
    """Where it is certainly below the margin; that is no decision, and needs known ends."""
    looks = Looks((4, 12, 48), margin=0.1)
    found = ruled(spread=0.01, looks=looks, ends=(-0.1, 0.3))
    assert found.small == 0.1
    assert found.is_over
    assert not found.is_decided
    assert ruled(spread=0.01, looks=looks, ends=(-np.inf, np.inf)).small is None


@pytest.mark.parametrize(
    ("seeds", "futile"),
    [((2, 3, 4, 6), [False, False, True, True]), (ONE_PLACE, [False, True, True, True, True, True])],
)
def test_small_differences_end_it_at_the_last_five_looks_from_four_seeds(seeds, futile):
    """Before that a few seeds are alike by luck."""
    looks = Looks(seeds)
    assert [looks.is_futile_at(look) for look in range(len(seeds))] == futile


def test_usual_looks_depend_on_the_places(subtests):
    """Two seeds in each of four places are as many as eight in one."""
    for places in range(1, 10):
        with subtests.test(places=places):
            assert looks_for(places) == (SEVERAL_PLACES if places >= 4 else ONE_PLACE)


@pytest.mark.parametrize(
    ("seeds", "told"),
    [
        *(((), "have to increase"), ((6, 6), "have to increase"), ((8, 6), "have to increase")),
        ((1, 4), "at least 2 seeds"),
        *((fine, "") for fine in (ONE_PLACE, SEVERAL_PLACES, (2,), (3, 7))),
    ],
)
def test_looks_that_cannot_be_used_say_why(seeds, told):
    """What is allowed, with an example."""
    said = check_looks(seeds)
    assert told in said
    assert bool(said) == bool(told)
