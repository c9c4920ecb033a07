"""Scores: what the env would track and pay."""

import numpy as np
import pytest

from harness.audit.score import discounted_sum, pay_distances, samples_of, score_rollout
from harness.errors import SimulationDiverged

DISTANCES = np.array([[0.5], [0.4], [0.6], [0.4], [0.1]])


def test_samples_are_what_the_env_tracks():
    """Begin, previous best, previous distance, distance, their difference and the step count."""
    rows = [[float(part[0]) for part in sample] for sample in samples_of(DISTANCES)]
    assert np.array(rows) == pytest.approx(
        np.array(
            [
                [0.5, 0.5, 0.5, 0.4, -0.1, 1.0],
                [0.5, 0.4, 0.4, 0.6, 0.2, 2.0],
                [0.5, 0.4, 0.6, 0.4, 0.0, 3.0],
                [0.5, 0.4, 0.4, 0.1, -0.3, 4.0],
            ]
        )
    )


def test_the_carry_goes_from_step_to_step(toolbox):
    """A reward that counts improvements counts them."""
    assert pay_distances(toolbox.counting(), DISTANCES)[:, 0] == pytest.approx([1.0, 1.0, 2.0, 3.0])


def test_discounting_starts_with_the_second_step():
    """Sum of gamma^t r(t), t from 0."""
    assert discounted_sum(np.array([[1.0], [10.0], [100.0]]), 0.5) == pytest.approx([31.0])


def test_no_discount_is_the_sum():
    """With gamma 1 all steps weigh the same."""
    assert discounted_sum(np.array([[1.0], [10.0], [100.0]]), 1.0) == pytest.approx([111.0])


def test_a_number_that_is_not_finite_is_an_error(toolbox, by_script):
    """A reward that pays NaN in a rollout is named with the script and the step."""
    broken = toolbox.paying(lambda sample: np.where(sample.step == 2.0, np.nan, 0.0))
    with pytest.raises(SimulationDiverged, match=r"'hover'.*step 2"):
        score_rollout(broken, by_script["hover"])


def test_what_is_paid_after_the_end_does_not_count(toolbox, by_script):
    """Not even where it is no number."""
    finish = by_script["finish"]
    after = toolbox.paying(lambda sample: np.where(sample.distance > 0.05, 1.0, np.nan))
    last = np.where(finish.running, finish.distances[1:] > 0.05, True)
    late = finish.running & ~last
    assert late.any()
    with pytest.raises(SimulationDiverged):
        score_rollout(after, finish)
    fine = toolbox.paying(lambda sample: np.where(sample.step > finish.steps, np.inf, 1.0))
    assert score_rollout(fine, finish).values.sum(axis=0) == pytest.approx(finish.steps)


def test_what_nothing_can_be_counted_with_is_an_error(toolbox, by_script):
    """A sum of such numbers would be beyond all numbers."""
    huge = toolbox.paying(lambda sample: np.full(len(sample.step), 1e200))
    with pytest.raises(SimulationDiverged, match=r"'hover' more than 1e\+150 at step 1"):
        score_rollout(huge, by_script["hover"])
