"""The statistic of a question, in every way to deal the labels."""

import numpy as np
import pytest
import scipy.stats
from hypothesis import given, strategies as st

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


@given(st.integers(3, 12), st.integers(1, 3), st.integers(0, 1000))
def test_without_known_ends_the_bound_is_welchs_interval(seeds, places, seed):
    """As scipy computes it; over several places that of the seeds' means, unless the places alone leave more open."""
    values = values_of(seeds, places, effect=0.5, seed=seed)
    means = values[..., 0].mean(axis=2)
    theirs = scipy.stats.ttest_ind(means[1], means[0], equal_var=False).confidence_interval(0.95)
    low, high = Question.of(values).bounds(0, 0.95)
    if places == 1:
        assert (low, high) == pytest.approx((theirs.low, theirs.high))
    assert low <= theirs.low + 1e-9
    assert high >= theirs.high - 1e-9


@pytest.mark.parametrize("side", [0, 1])
def test_one_training_more_lies_where_it_speaks_most_against_the_word(side):
    """At the end that is known, of the reward for which it widens the bound more; by hand."""
    values = np.array([[0.2, 0.3, 0.25, 0.3], [0.9, 0.95, 0.85, 0.9]])
    alone = []
    for added, end in ((0, 1.0), (1, 0.0)):
        sides = [np.append(it, end) if at == added else it for at, it in enumerate(values)]
        alone.append(scipy.stats.ttest_ind(*sides[::-1], equal_var=False).confidence_interval(0.95).low)
    ends = np.array([[[0.0, 1.0]]])
    question = Question.of(values[[side, 1 - side], :, None, None], ends)
    found = question.bounds(0, 0.95)
    assert (found[0] if side == 0 else -found[1]) == pytest.approx(min(alone))
    assert question.leaning(0, 0.95) == (0 if min(alone) <= 0.0 else 1 - 2 * side)


@pytest.mark.parametrize("lost", [0, 1, 2])
def test_a_training_without_a_value_lies_there_too(lost):
    """As if so many of the proposed reward's had ended at 0, for the word that it helps."""
    values = np.full((2, 8, 1, 1), np.nan)
    values[0, :6, 0, 0], values[1, : 6 - lost, 0, 0] = 0.2, 0.9
    values[:, ::2] += 0.01
    begun = np.isfinite(values[..., 0])
    begun[1, 6 - lost : 6] = True
    ends = np.array([[[0.0, 1.0]]])
    filled = np.where(begun[..., None] & ~np.isfinite(values), 0.0, values)
    found, expected = Question.of(values, ends, begun), Question.of(filled, ends)
    assert found.bounds(0, 0.95)[0] == pytest.approx(expected.bounds(0, 0.95)[0])
    assert found.has_lost == (lost > 0)
    assert Question.of(values, None, begun).leaning(0, 0.95) == 0


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
    assert question.differences[0, 0] == pytest.approx(kept.mean() - values[0].mean())
    assert question.means == pytest.approx((values[0].mean(), kept.mean()))


def test_trainings_that_only_one_side_has_keep_their_label_and_count():
    """Two of five baselines were not trained in the second place, where the proposed reward has all."""
    values = values_of(5, places=2)
    values[0, 3:, 1] = np.nan
    question = Question.of(values)
    assert question.layout.strata == ((0, 2, 0), (1, 3, 5))
    assert question.counts == (3, 5)
    expected = np.nanmean(values[1], axis=0) - np.nanmean(values[0], axis=0)
    assert question.differences == pytest.approx(expected)
    assert (question.deals[:, :2] == 0.0).all()
    assert np.isfinite(question.statistics()).all()


@pytest.mark.parametrize(("seeds", "is_testable"), [(1, False), (2, True)])
def test_one_seed_has_no_spread(seeds, is_testable):
    """And so no test."""
    assert Question.of(values_of(seeds)).is_testable == is_testable


def test_among_some_trainings_the_others_are_not_begun():
    """As if they had never been."""
    question = Question.of(values_of(6))
    some = question.among(np.arange(6)[:, None] < 3)
    assert some.statistics() == pytest.approx(Question.of(values_of(6)[:, :3]).statistics())
    assert some.counts == (3, 3)
    assert not some.has_lost


def test_places_keep_their_ends():
    """Those that they are about."""
    ends = np.array([[[0.0, 1.0]], [[-9.0, 0.0]]])
    question = Question.of(values_of(4, places=2), ends)
    assert question.in_places(np.array([1])).ends.tolist() == [[[-9.0, 0.0]]]
