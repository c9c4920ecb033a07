"""A measure under two rewards, means over several places."""

import numpy as np
import pytest

from harness.arrays import Float
from harness.eta.behaviour_change import Measure
from harness.eta.verdict.question import Question
from harness.eta.verdict.together import Together

SUCCESS = Measure("success_rate", "", "higher", "deterministic", 100)
TIME = Measure("time_to_target", "s", "lower", "deterministic")


def together(values: Float, measure: Measure = TIME) -> Together:
    """Of values, (2, seeds, places)."""
    return Together(measure, Question.of(values[..., None]))


def test_means_are_over_seeds_and_then_over_places():
    """Every place counts alike."""
    values = np.zeros((2, 4, 2))
    values[1, :, 0] = 1.0
    assert (together(values).baseline, together(values).proposed) == (0.0, 0.5)


def test_the_interval_is_students_with_the_seeds_less_one():
    """Of a measure that is no share."""
    values = np.random.default_rng(0).normal(size=(2, 6, 3))
    found = together(values)
    means = values.mean(axis=2)
    error = np.sqrt(means.var(axis=1, ddof=1).sum() / 6)
    assert (found.high - found.low) / 2 == pytest.approx(2.570582 * error)


def test_where_no_seed_failed_an_interval_of_success_is_not_empty():
    """It knows of one seed, in one of the places, that was not seen."""
    found = together(np.ones((2, 8, 4)), SUCCESS)
    assert found.low < -0.01
    assert found.high > 0.01


def test_the_seed_that_was_not_seen_counts_less_in_more_places():
    """One of its places of four, one of sixteen."""
    few, many = (together(np.ones((2, 8, places)), SUCCESS) for places in (4, 16))
    assert many.high == pytest.approx(few.high / 2)


def test_two_seeds_have_no_interval():
    """As in a single place."""
    found = together(np.zeros((2, 2, 4)))
    assert (found.low, found.high, found.likely) == (None, None, None)


def test_a_share_differs_by_one_at_most():
    """The interval is cut there."""
    values = np.zeros((2, 3, 1))
    values[1] = 1.0
    assert together(values, SUCCESS).high == 1.0


def test_the_lowest_value_is_that_of_a_single_seed():
    """Of either reward, in any place."""
    values = np.ones((2, 3, 2))
    values[1, 2, 1] = 0.25
    assert together(values).lowest == 0.25
