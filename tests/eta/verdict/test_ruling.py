"""What the test says of questions that are asked together."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.stats
from numpy.random import default_rng

from harness.eta import Question, Ruling, rule
from harness.eta.verdict.ruling import better_in, opposed_in, rule_places
from tests.eta.scenarios import question_of, values_of


def ruling_of(question):
    """What the test says of one question."""
    (found,) = rule([question])
    return found


def ended(question, ends=(-12.0, 12.0)):
    """The same question, of measures with known ends."""
    return replace(question, ends=np.broadcast_to(ends, question.ends.shape))


def test_p_of_one_question_is_that_of_all_permutations(subtests):
    """As scipy finds it, with the same statistic, also where one reward has more trainings."""
    for baselines, proposed, effect in [
        (3, 3, 0.5),
        (4, 4, -1.5),
        (5, 5, 1.0),
        (10, 5, 1.0),
        (5, 10, 0.6),
        (7, 2, 2.0),
    ]:
        with subtests.test(baselines=baselines, proposed=proposed, effect=effect):
            values = values_of(max(baselines, proposed), effect=effect, seed=baselines)
            values[0, baselines:], values[1, proposed:] = np.nan, np.nan
            theirs = scipy.stats.permutation_test(
                (values[1, :proposed, 0, 0], values[0, :baselines, 0, 0]),
                lambda one, other, axis: np.abs(
                    scipy.stats.ttest_ind(one, other, axis=axis, equal_var=False).statistic
                ),
                alternative="greater",
                vectorized=True,
                n_resamples=np.inf,
            )
            assert ruling_of(Question.of(values)).p == pytest.approx(theirs.pvalue)


def test_p_of_as_many_trainings_of_each_stays(subtests):
    """To the last bit, as it was when only trainings with a namesake under the other reward counted."""
    for seeds, places, measures, effect, seed, p in [
        (4, 1, 1, 0.5, 0, (0.11428571428571428,)),
        (5, 1, 2, 0.8, 1, (0.9444444444444444, 0.2222222222222222)),
        (6, 3, 2, 0.6, 2, (0.36147186147186144, 0.025974025974025976)),
        (8, 1, 3, 1.0, 3, (0.9676767676767677, 0.008702408702408702, 0.0003108003108003108)),
        (10, 4, 2, 0.3, 4, (0.0118, 0.35765)),
        (20, 1, 2, 0.4, 5, (0.00135, 0.36555)),
        (7, 2, 1, -0.7, 6, (0.0944055944055944,)),
    ]:
        with subtests.test(seeds=seeds, places=places, measures=measures, effect=effect, seed=seed, p=p):
            found = ruling_of(question_of(seeds, places, measures, effect, seed))
            assert (found.p, found.of_measures) == (min(p), p)


def test_the_larger_of_two_measures_counts():
    """M is their maximum; each measure is held against it."""
    found = ruling_of(question_of(5, measures=2, effect=[0.0, 3.0]))
    assert (found.decider, found.sign) == (1, 1)
    assert found.of_measures[1] == found.corrected
    assert found.of_measures[0] > found.of_measures[1]


@pytest.mark.parametrize(("seeds", "p", "is_told"), [(4, 2 / 70, True), (3, 0.1, False)])
def test_four_seeds_can_tell(seeds, p, is_told):
    """The smallest p is 2 / 70, of three 2 / 20. Without known ends only these trainings are told about."""
    found = ruling_of(question_of(seeds, effect=9.0))
    assert (found.p, found.is_ahead, found.is_decided) == (pytest.approx(p), is_told, False)
    apart = np.stack([np.zeros((seeds, 1, 1)), np.ones((seeds, 1, 1))])
    assert ruling_of(ended(Question.of(apart), (0.0, 1.0))).is_decided == is_told


@pytest.mark.parametrize("offered", [0, 10])
def test_a_measure_that_was_chosen_from_several_is_held_against_all(offered):
    """Its p is that of the largest of all, and its bound is wider."""
    values = values_of(8, measures=1 + offered, effect=[1.2, *[0.0] * offered])
    (found,), (named,) = rule([Question.of(values)], offered=[offered]), rule([Question.of(values[..., :1])])
    assert (found.p >= named.p, len(found.signs), found.asked) == (True, 1, 1 + offered)
    assert (found.p > named.p) == (found.confidence > 0.95) == (offered > 0)


def test_what_left_no_value_has_to_agree():
    """Who drops its bad trainings is not ahead of who keeps them."""
    rng = default_rng(0)
    values = np.stack([rng.uniform(0.0, 1.0, 10), rng.uniform(0.8, 1.0, 10)])[..., None, None]
    begun = np.ones(values.shape[:3], bool)
    assert ruling_of(ended(Question.of(values, begun=begun), (0.0, 1.0))).is_ahead
    values[1, 5:] = np.nan
    dropped = ruling_of(ended(Question.of(values), (0.0, 1.0)))
    found = ruling_of(ended(Question.of(values, begun=begun), (0.0, 1.0)))
    assert dropped.sign == 1
    assert not found.is_ahead
    assert not found.is_decided


def test_one_seed_has_no_ruling():
    """And it takes nothing from the others."""
    few, many = question_of(1), question_of(6, effect=3.0)
    found = rule([few, many])
    assert (found[0].p, found[0].corrected) == (None, None)
    assert found[1].corrected == found[1].p
    assert found[1].asked == 1


def test_questions_that_are_asked_together_are_corrected():
    """None gets a smaller p than alone, nor more than by Bonferroni, and the order of the p-values stays."""
    questions = [question_of(6, effect=effect, seed=seed) for seed, effect in enumerate((0.0, 1.0, 2.0, 3.0))]
    alone = [ruling_of(it).p for it in questions]
    together = [it.corrected for it in rule(questions)]
    assert all(one <= other for one, other in zip(alone, together, strict=True))
    assert np.argsort(alone).tolist() == np.argsort(together).tolist()
    found = min(rule([question_of(6, seed=seed) for seed in range(5)]), key=lambda it: it.p)
    assert found.p < found.corrected <= 5 * found.p


def test_a_question_in_which_nothing_varies_takes_nothing_from_the_others():
    """Two rewards that succeed always cannot pass by chance either."""
    still, moving = Question.of(np.ones((2, 6, 1, 1))), question_of(6, effect=4.0)
    found = rule([still, moving])
    assert found[0].corrected == 1.0
    assert found[1].corrected == pytest.approx(found[1].p)


def test_questions_of_unlike_seeds_are_corrected_by_holm():
    """They share no ways to deal labels."""
    low, high = sorted(rule([question_of(5, effect=3.0), question_of(7, effect=3.0, seed=1)]), key=lambda it: it.p)
    assert low.corrected == pytest.approx(2 * low.p)
    assert high.corrected == pytest.approx(max(low.corrected, high.p))


def test_swapping_the_rewards_swaps_the_sign():
    """And nothing else."""
    values = values_of(5, effect=2.0)
    one, other = (ruling_of(Question.of(it)) for it in (values, values[::-1]))
    assert one.p == pytest.approx(other.p)
    assert one.sign == -other.sign


def test_measures_that_both_pass_with_opposite_signs_are_contrary():
    """The answer says so."""
    found = ruling_of(ended(question_of(20, measures=2, effect=[9.0, -9.0])))
    assert found.is_decided
    assert found.is_contrary


def test_questions_over_places_are_corrected_as_those_in_one_place():
    """By the step-down procedure: the largest p of three that all pass is not multiplied by three."""
    found = rule([question_of(8, places=3, effect=effect, seed=seed) for seed, effect in enumerate((1.5, 2.0, 2.5))])
    assert all(it.is_ahead for it in found)
    last = max(found, key=lambda it: it.p)
    assert last.corrected < 3 * last.p
    assert {it.asked for it in found} == {3}


def test_a_place_is_decided_only_where_all_places_together_are():
    """Whatever its own p is."""
    question = question_of(5, places=2, effect=[[9.0], [-9.0]])
    whole = ruling_of(question)
    assert not whole.is_decided
    assert not any(it.is_decided for it in rule_places(question, whole))


def test_single_places_are_told_where_the_answer_stands():
    """The place with the effect passes, the other one does not; without an answer none is opposed or better."""
    question, undecided = ended(question_of(20, places=2, effect=[[9.0], [0.0]])), Ruling(p=0.5, corrected=0.5)
    whole = ruling_of(question)
    found = rule_places(question, whole)
    assert [it.is_decided for it in found] == [True, False]
    assert opposed_in(whole, found) == opposed_in(undecided, rule_places(question, undecided)) == 0
    assert better_in(question, undecided) == 0


def test_a_single_place_takes_nothing_but_its_level_from_the_answer_over_all():
    """Neither its p nor that it is small; of measures that were offered it says nothing."""
    question = ended(question_of(20, places=2, measures=2, effect=9.0))
    (whole,) = rule([question], offered=[1])
    small = replace(whole, small=0.1, beyond=(False,))
    for found in (*rule_places(question, whole), *rule_places(question, small)):
        assert (found.p, found.corrected, found.of_measures, found.small) == (None, None, (), None)
        assert len(found.beyond) == len(found.signs) == 1
        assert found.asked == 2 * whole.asked


def test_a_place_that_goes_the_other_way_is_opposed():
    """Better in three places, worse in the fourth, and the mean says better."""
    question = ended(question_of(20, places=4, effect=[*[[9.0]] * 3, [-9.0]], seed=1))
    whole = ruling_of(question)
    assert whole.sign == 1
    assert opposed_in(whole, rule_places(question, whole)) == 1


@pytest.mark.parametrize(("affected", "least"), [(4, 3), (1, 1)])
def test_better_in_so_many_places_at_least(affected, least):
    """Never more than those in which something happens."""
    question = ended(question_of(20, places=4, effect=9.0 * np.eye(4)[:, :affected].sum(axis=1, keepdims=True), seed=3))
    assert least <= better_in(question, ruling_of(question)) <= affected


def test_of_many_places_single_ones_count():
    """Too many for all of their sets."""
    question = ended(question_of(40, places=12, effect=[*[[9.0]] * 5, *[[0.0]] * 7]))
    assert better_in(question, ruling_of(question)) == 5
