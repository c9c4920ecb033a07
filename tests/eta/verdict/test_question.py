"""The statistic of a question, in every way to deal the labels."""

import itertools

import numpy as np
import pytest
import scipy.stats
from hypothesis import given, strategies as st
from numpy.random import default_rng

from harness.eta import Question
from tests.eta.scenarios import values_of


def with_counts(values, baselines, proposed):
    """The values with only so many trainings of each side."""
    kept = values.copy()
    kept[0, baselines:], kept[1, proposed:] = np.nan, np.nan
    return kept


@given(st.integers(3, 12), st.integers(1, 4), st.integers(0, 1000))
def test_the_statistic_is_welchs_t_of_the_mean_over_places(seeds, places, seed):
    """As scipy computes it. Seeds that were trained in all places are the unit."""
    values = values_of(seeds, places, effect=0.5, seed=seed)
    means = values[..., 0].mean(axis=2)
    theirs = scipy.stats.ttest_ind(means[1], means[0], equal_var=False)
    question = Question.of(values)
    assert question.statistics()[0, 0] == pytest.approx(theirs.statistic)
    assert question.estimate.freedom == pytest.approx(theirs.df)


@pytest.mark.parametrize(("baselines", "proposed"), [(4, 4), (5, 3)])
def test_every_way_to_deal_is_the_statistic_of_the_dealt_values(baselines, proposed):
    """Not only the first. Seeds that were trained in both places are the unit; either side has its own number."""
    question = Question.of(with_counts(values_of(5, places=2), baselines, proposed))
    sides = question.values[0, :baselines], question.values[1, :proposed]
    pooled = np.concatenate(sides)[..., 0].mean(axis=1)
    for deal, found in zip(question.deals, question.statistics()[:, 0], strict=True):
        theirs = scipy.stats.ttest_ind(pooled[deal == 1.0], pooled[deal == 0.0], equal_var=False)
        assert found == pytest.approx(theirs.statistic)


def test_seeds_of_single_places_are_no_seeds_of_the_others():
    """Each place then has labels and a variance of its own, and the variances add."""
    seeds, values = 4, np.full((2, 8, 2, 1), np.nan)
    drawn = values_of(seeds, 2)
    values[:, :4, 0], values[:, 4:, 1] = drawn[:, :, 0], drawn[:, :, 1]
    question = Question.of(values)
    sides = drawn[..., 0]
    difference = (sides[1] - sides[0]).mean()
    error = np.sqrt(sides.var(axis=1, ddof=1).sum() / seeds) / 2
    assert question.statistics()[0, 0] == pytest.approx(difference / error)
    assert question.layout.strata == ((0, 4, 4), (1, 4, 4))


def test_a_shift_changes_nothing():
    """Statistics are about differences."""
    values = values_of(5, 2, 2)
    assert Question.of(values + 7.0).statistics() == pytest.approx(Question.of(values).statistics())


def test_a_place_without_spread_has_an_error_all_the_same():
    """A thousandth of the pooled standard deviation: no statistic is infinite."""
    values = np.zeros((2, 5, 1, 1))
    values[1] = 1.0
    found = Question.of(values).statistics()
    pooled = np.sqrt(10 * 0.25 / 9)
    assert np.isfinite(found).all()
    assert found[0, 0] == pytest.approx(1.0 / (0.001 * pooled))


def test_where_nothing_varies_the_statistic_is_zero():
    """Two rewards that succeed always."""
    assert (Question.of(np.ones((2, 5, 1, 1))).statistics() == 0.0).all()


def test_a_training_that_is_missing_takes_none_of_the_other_reward_with_it():
    """All that were done count, as in scipy's Welch t."""
    values = values_of(5, effect=0.5)
    values[1, 2] = np.nan
    question = Question.of(values)
    kept = values[1, np.isfinite(values[1, :, 0, 0]), 0, 0]
    theirs = scipy.stats.ttest_ind(kept, values[0, :, 0, 0], equal_var=False)
    assert question.counts == (5, 4)
    assert question.seeds == 4
    assert question.statistics()[0, 0] == pytest.approx(theirs.statistic)
    assert question.estimate.freedom == pytest.approx(theirs.df)
    assert question.differences[0, 0] == pytest.approx(kept.mean() - values[0].mean())
    assert question.means == pytest.approx((values[0].mean(), kept.mean()))


@given(st.integers(2, 7), st.integers(2, 7), st.integers(1, 3), st.integers(0, 1000))
def test_rows_are_not_paired(baselines, proposed, places, seed):
    """Where the trainings of a side stand changes nothing."""
    values = with_counts(values_of(7, places, 2, effect=0.7, seed=seed), baselines, proposed)
    rng, mixed = default_rng(seed), values.copy()
    for side in (0, 1):
        mixed[side] = values[side, rng.permutation(7)]
    one, other = Question.of(values), Question.of(mixed)
    assert one.statistics()[0] == pytest.approx(other.statistics()[0])
    assert one.estimate == pytest.approx(other.estimate)


def test_trainings_that_only_one_side_has_keep_their_label_and_count():
    """Two of five baselines were not trained in the second place, where the proposed reward has all."""
    values = values_of(5, places=2)
    values[0, 3:, 1] = np.nan
    question = Question.of(values)
    assert question.layout.strata == ((0, 2, 0), (1, 3, 5))
    assert question.counts == (3, 5)
    expected = np.nanmean(values[1], axis=0) - np.nanmean(values[0], axis=0)
    assert question.differences == pytest.approx(expected)
    assert question.estimate.difference == pytest.approx(expected.mean())
    assert (question.deals[:, :2] == 0.0).all()
    assert np.isfinite(question.statistics()).all()


@pytest.mark.parametrize(("seeds", "is_testable"), [(1, False), (2, True)])
def test_one_seed_has_no_spread(seeds, is_testable):
    """And so no test."""
    assert Question.of(values_of(seeds)).is_testable == is_testable


@pytest.mark.parametrize(("baselines", "proposed"), [(4, 4), (3, 5)])
def test_subsets_of_places_have_the_statistic_of_their_mean(baselines, proposed):
    """Every subset, in every way, is the question about these places alone."""
    values = with_counts(values_of(5, places=3), baselines, proposed)
    subsets = np.array([it for it in itertools.product((0.0, 1.0), repeat=3) if any(it)])
    found = np.concatenate(list(Question.of(values).subset_statistics(subsets)))
    for at, subset in enumerate(subsets):
        assert found[:, at] == pytest.approx(Question.of(values[:, :, subset == 1.0]).statistics())


def test_until_a_look_later_seeds_are_unknown():
    """And the places that they were trained in."""
    values, looks = values_of(6), np.array([[0], [0], [0], [1], [1], [2]])
    question = Question.of(values, looks=looks)
    assert question.until(1).values.shape[1] == 5
    assert question.until(0).statistics() == pytest.approx(Question.of(values[:, :3]).statistics())


def test_a_place_and_a_look_keep_their_ends():
    """Of the places that they are about."""
    ends = np.array([[[0.0, 1.0]], [[-9.0, 0.0]]])
    question = Question.of(values_of(4, places=2), ends)
    assert question.in_places(np.array([1])).ends.tolist() == [[[-9.0, 0.0]]]
    assert question.until(0).ends is ends
