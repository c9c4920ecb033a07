"""A question that is asked several times, while seeds come in."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.random import default_rng

from harness.eta import Looks, rule, rule_in_looks
from harness.eta.verdict.least_p import both_sides, crossed_before
from harness.eta.verdict.looks import check_looks, looks_for
from tests.eta.scenarios import ONE_PLACE, SEVERAL_PLACES, question_in_looks, values_of

LOOKS = Looks((4, 6, 8, 12))


def question_of(effect=0.0, spread=1.0, seed=0, looks=LOOKS):
    """Normal values of all seeds in one place."""
    values = spread * values_of(looks.most, seed=seed)
    values[1] += effect
    return question_in_looks(values.swapaxes(1, 2), looks)


def test_nothing_is_said_before_the_first_look():
    """And nothing is over."""
    found = rule_in_looks(question_of(9.0), LOOKS, 0)
    assert (found.p, found.is_over) == (None, False)


def test_a_large_effect_ends_at_an_early_look():
    """Later seeds are not asked for."""
    found = rule_in_looks(question_of(9.0), LOOKS, 4)
    assert found.is_decided
    assert found.look < 3
    assert found.sign == 1


def test_the_answer_of_a_look_stands_when_more_seeds_come():
    """What was trained beside it changes nothing."""
    question = question_of(3.0)
    answers = [rule_in_looks(question, LOOKS, complete) for complete in range(1, 5)]
    first = next(at for at, it in enumerate(answers) if it.is_decided)
    assert all(it == answers[first] for it in answers[first:])


def test_a_look_is_judged_by_what_was_there_then():
    """The question with all seeds and the one with those of the look say the same."""
    question = question_of(1.0)
    assert rule_in_looks(question, LOOKS, 2) == rule_in_looks(question.until(1), LOOKS, 2)


def test_the_last_look_ends_it():
    """Whatever is found."""
    found = rule_in_looks(question_of(0.0, seed=1), replace(LOOKS, margin=0.001), 4)
    assert found.is_last
    assert found.is_over
    assert not found.is_decided


def test_one_look_alone_is_the_test_of_all_seeds():
    """There is nothing to spend before."""
    looks = Looks((6,))
    question = question_of(1.0, looks=looks)
    (at_once,) = rule([replace(question, looks=np.zeros((6, 1), np.int64))])
    found = rule_in_looks(question, looks, 1)
    assert found.p == pytest.approx(at_once.p, abs=0.01)  # drawn ways beside all ways


def test_a_look_spends_in_proportion_to_its_seeds():
    """A third of the seeds, a third of 5 %."""
    assert [LOOKS.spent(look) for look in range(4)] == pytest.approx([0.05 / 3, 0.025, 0.1 / 3, 0.05])


def test_several_questions_share_the_level():
    """Each has a smaller one, so its corrected p is larger."""
    one, five = rule_in_looks(question_of(1.0), LOOKS, 1), rule_in_looks(question_of(1.0), replace(LOOKS, asked=5), 1)
    assert five.corrected == pytest.approx(min(1.0, 5 * one.corrected))


def test_a_small_difference_ends_it():
    """Where it is certainly below the margin; that is no decision."""
    found = rule_in_looks(question_of(0.0, spread=0.01), replace(LOOKS, margin=0.1), 4)
    assert found.small == 0.1
    assert found.is_over
    assert not found.is_decided


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


def perfect_beside(steady):
    """A proposed reward of which every training succeeds, beside a baseline that is always nearly as good."""
    baseline = steady + 0.01 * default_rng(0).normal(size=(1, ONE_PLACE[-1], 1))
    values = np.stack([baseline, np.ones_like(baseline)])
    return question_in_looks(values, Looks(ONE_PLACE), np.array([[[0.0, 1.0]]]))


@pytest.mark.parametrize(("steady", "seeds"), [(0.5, 8), (0.7, 16), (0.8, 24)])
def test_trainings_that_all_succeed_are_believed_at_a_look_that_luck_hardly_reaches(steady, seeds):
    """Twice the chance of no failure, and what luck had at earlier looks, is below what may be spent."""
    found = rule_in_looks(perfect_beside(steady), Looks(ONE_PLACE), len(ONE_PLACE))
    assert found.is_decided
    assert ONE_PLACE[found.look] == seeds
    assert found.p > 2.0 * (steady - 0.01) ** seeds


def test_luck_has_one_level_over_all_looks(subtests):
    """Failures alone, 20,000 experiments with as many failures as the steady baseline misses: below 5 % in all."""
    for places in [1, 4]:
        for share in [0.1, 0.2, 0.35, 0.5]:
            with subtests.test(places=places, share=share):
                looks, levels = [places * seeds for seeds in ONE_PLACE], [0.05 * seeds / 32 for seeds in ONE_PLACE]
                failed = (default_rng(0).random((20_000, looks[-1])) < share).cumsum(axis=1)
                is_decided = np.zeros(len(failed), np.bool_)
                for at, (count, level) in enumerate(zip(looks, levels, strict=True)):
                    chances = crossed_before(looks[:at], levels[:at], share) + both_sides(count, share)
                    is_decided |= chances[failed[:, count - 1]] <= level
                assert 0.005 < is_decided.mean() < 0.045
