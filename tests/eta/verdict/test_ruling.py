"""What the test says of questions that are asked together."""

import numpy as np
import pytest
import scipy.stats
from hypothesis import given, settings
from hypothesis import strategies as st

from harness.arrays import Float
from harness.eta.verdict.question import Question
from harness.eta.verdict.ruling import Ruling, better_in, rule, rule_alone, rule_places


def values_of(seeds: int, places: int = 1, measures: int = 1, effect: float = 0.0, seed: int = 0) -> Float:
    """Normal values, (2, seeds, places, measures)."""
    values = np.random.default_rng(seed).normal(size=(2, seeds, places, measures))
    values[1] += effect
    return values


def question_of(seeds: int, places: int = 1, measures: int = 1, effect: float = 0.0, seed: int = 0) -> Question:
    """A question about such values."""
    return Question.of(values_of(seeds, places, measures, effect, seed))


@given(st.integers(3, 5), st.floats(-2.0, 2.0), st.integers(0, 100))
@settings(max_examples=30)
def test_p_of_one_question_is_that_of_all_permutations(seeds: int, effect: float, seed: int):
    """As scipy finds it, with the same statistic."""
    question = question_of(seeds, effect=effect, seed=seed)

    def size(one: Float, other: Float, axis: int) -> Float:
        return np.abs(scipy.stats.ttest_ind(one, other, axis=axis, equal_var=False).statistic)

    theirs = scipy.stats.permutation_test(
        (question.values[1, :, 0, 0], question.values[0, :, 0, 0]),
        size,
        alternative="greater",
        vectorized=True,
        n_resamples=np.inf,
    )
    assert rule([question])[0].p == pytest.approx(theirs.pvalue)


def test_the_larger_of_two_measures_counts():
    """M is their maximum; each measure is held against it."""
    values = values_of(5, measures=2)
    values[1, :, :, 1] += 3.0
    (found,) = rule([Question.of(values)])
    assert (found.decider, found.sign) == (1, 1)
    assert found.of_measures[1] == found.corrected
    assert found.of_measures[0] > found.of_measures[1]


def test_four_seeds_can_decide_one_question():
    """The smallest p is 2 / 70."""
    (found,) = rule([question_of(4, effect=9.0)])
    assert found.p == pytest.approx(2 / 70)
    assert found.is_decided


def test_three_seeds_cannot():
    """The smallest p is 2 / 20."""
    (found,) = rule([question_of(3, effect=9.0)])
    assert found.p == pytest.approx(0.1)
    assert not found.is_decided


def test_one_seed_has_no_ruling():
    """And it takes nothing from the others."""
    few, many = question_of(1), question_of(6, effect=3.0)
    found = rule([few, many])
    assert (found[0].p, found[0].corrected) == (None, None)
    assert found[1].corrected == found[1].p
    assert found[1].asked == 1


def test_questions_that_are_asked_together_are_corrected():
    """None gets a smaller p than alone, and the order of the p-values stays."""
    questions = [question_of(6, effect=effect, seed=seed) for seed, effect in enumerate((0.0, 1.0, 2.0, 3.0))]
    alone = [rule([it])[0].p for it in questions]
    together = [it.corrected for it in rule(questions)]
    assert all(one <= other for one, other in zip(alone, together, strict=True))
    assert np.argsort(alone).tolist() == np.argsort(together).tolist()


def test_the_smallest_p_is_corrected_by_all_the_others():
    """Not by more than Bonferroni would."""
    questions = [question_of(6, seed=seed) for seed in range(5)]
    found = rule(questions)
    first = min(found, key=lambda it: it.p or 1.0)
    assert first.p < first.corrected <= 5 * first.p


def test_a_question_in_which_nothing_varies_takes_nothing_from_the_others():
    """Two rewards that succeed always cannot pass by chance either."""
    still, moving = Question.of(np.ones((2, 6, 1, 1))), question_of(6, effect=4.0)
    found = rule([still, moving])
    assert found[0].corrected == 1.0
    assert found[1].corrected == pytest.approx(found[1].p)


def test_questions_of_unlike_seeds_are_corrected_by_holm():
    """They share no ways to deal labels."""
    questions = [question_of(5, effect=3.0), question_of(7, effect=3.0, seed=1)]
    found = rule(questions)
    low, high = sorted(found, key=lambda it: it.p)
    assert low.corrected == pytest.approx(2 * low.p)
    assert high.corrected == pytest.approx(max(low.corrected, high.p))


def test_swapping_the_rewards_swaps_the_sign():
    """And nothing else."""
    values = values_of(5, effect=2.0)
    one, other = rule([Question.of(values)])[0], rule([Question.of(values[::-1])])[0]
    assert one.p == pytest.approx(other.p)
    assert one.sign == -other.sign


def test_measures_that_both_pass_with_opposite_signs_are_contrary():
    """The answer says so."""
    values = values_of(6, measures=2)
    values[1, :, :, 0] += 9.0
    values[1, :, :, 1] -= 9.0
    (found,) = rule([Question.of(values)])
    assert found.is_decided
    assert found.is_contrary


def test_alone_is_corrected_by_bonferroni():
    """Over several places: 0.05 / K each."""
    question = question_of(5, places=3, effect=1.0)
    alone, of_three = rule_alone(question, 1), rule_alone(question, 3)
    assert of_three.corrected == pytest.approx(min(1.0, 3 * alone.corrected))
    assert of_three.asked == 3


def test_a_place_is_decided_only_where_all_places_together_are():
    """Whatever its own p is."""
    values = values_of(5, places=2)
    values[1, :, 0] += 9.0
    values[1, :, 1] -= 9.0
    question = Question.of(values)
    whole = rule_alone(question, 1)
    assert not whole.is_decided
    assert not any(it.is_decided for it in rule_places(question, whole))


def test_single_places_are_told_where_the_answer_stands():
    """The place with the effect passes, the other one does not."""
    values = values_of(8, places=2)
    values[1, :, 0] += 6.0
    question = Question.of(values)
    found = rule_places(question, rule_alone(question, 1))
    assert [it.is_decided for it in found] == [True, False]


@pytest.mark.parametrize(("affected", "least"), [(4, 3), (1, 1)])
def test_better_in_so_many_places_at_least(affected: int, least: int):
    """Never more than those in which something happens."""
    values = values_of(10, places=4, seed=3)
    values[1, :, :affected] += 5.0
    question = Question.of(values)
    found = better_in(question, rule_alone(question, 1))
    assert least <= found <= affected


def test_of_many_places_single_ones_count():
    """Too many for all of their sets."""
    values = values_of(10, places=12)
    values[1, :, :5] += 6.0
    question = Question.of(values)
    assert better_in(question, rule_alone(question, 1)) == 5


def test_better_in_none_without_an_answer():
    """What is not decided over all places is decided in none."""
    question = question_of(6, places=3)
    assert better_in(question, Ruling(p=0.5, corrected=0.5)) == 0
