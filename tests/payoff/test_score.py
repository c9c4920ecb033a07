"""Scores: what the env would track and pay."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from harness.errors import SimulationDiverged
from harness.payoff.rollout import pay_distances, score_rollout, steps_along
from harness.reward.steps import MissingField
from tests.payoff.conftest import Counting, Paying
from tests.refusals import refused

DISTANCES = np.array([[0.5], [0.4], [0.6], [0.4], [0.1]])


def test_steps_are_what_the_env_tracks():
    """Begin, previous best, previous distance, distance, their difference and the step count."""
    rows = [[float(part[0]) for part in step] for step in steps_along({"distance": DISTANCES})]
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


def test_the_carry_goes_from_step_to_step():
    """A reward that counts improvements counts them."""
    assert pay_distances(Counting(), DISTANCES)[:, 0] == pytest.approx([1.0, 1.0, 2.0, 3.0])


def test_steps_have_what_the_states_have(by_script):
    """Now and before; a step before the first is at rest."""
    states = by_script["creep"].states
    first, second, *_ = steps_along(states)
    assert (first.action == states["action"][1]).all()
    assert (second.before.action == first.action).all()
    assert not first.before.action.any()
    assert not first.before.qvel.any()


def test_made_up_distances_have_no_more():
    """A reward that reads more is refused by the field's name."""
    with pytest.raises(MissingField, match="no 'action'"):
        pay_distances(Paying(lambda step: step.action[:, 0]), DISTANCES)


def test_terms_are_scored_each(by_script):
    """They add up to the value to the last bit, and are 0 after the end too."""
    reward = Paying(lambda step: {"reach": -step.distance, "effort": -0.1 * (step.action**2).sum(-1)})
    score = score_rollout(reward, by_script["finish"])
    assert list(score.terms) == ["reach", "effort"]
    assert_array_equal(score.terms["reach"] + score.terms["effort"], score.values)
    assert not score.terms["effort"][~score.rollout.running].any()
    assert score.terms["effort"].any()


def test_terms_that_change_are_an_error(by_script):
    """A table of them would be another one in every step."""
    reward = Paying(lambda step: {"early" if step.step[0] < 3 else "late": -step.distance})
    with refused("terms early at first, and now late"):
        score_rollout(reward, by_script["creep"])


def test_a_term_that_is_not_finite_is_named(by_script):
    """And not the reward, which it spoils."""
    reward = Paying(lambda step: {"reach": -step.distance, "odd": step.distance / (step.step != 4.0)})
    with pytest.raises(SimulationDiverged, match="the term 'odd' pays 'creep' inf, no number within"):
        score_rollout(reward, by_script["creep"])


def test_a_number_that_is_not_finite_is_an_error(by_script):
    """A reward that pays NaN in a rollout is named with the script and the step."""
    broken = Paying(lambda sample: np.where(sample.step == 2.0, np.nan, 0.0))
    with pytest.raises(SimulationDiverged, match=r"'hover'.*step 2"):
        score_rollout(broken, by_script["hover"])


def test_what_is_paid_after_the_end_does_not_count(by_script):
    """Not even where it is no number."""
    finish = by_script["finish"]
    after = Paying(lambda sample: np.where(sample.distance > 0.05, 1.0, np.nan))
    late = finish.running & ~np.where(finish.running, finish.distances[1:] > 0.05, True)
    assert late.any()
    with pytest.raises(SimulationDiverged):
        score_rollout(after, finish)
    fine = Paying(lambda sample: np.where(sample.step > finish.steps, np.inf, 1.0))
    assert score_rollout(fine, finish).values.sum(axis=0) == pytest.approx(finish.steps)


def test_what_nothing_can_be_counted_with_is_an_error(by_script):
    """A sum of such numbers would be beyond all numbers."""
    huge = Paying(lambda sample: np.full(len(sample.step), 1e200))
    with pytest.raises(SimulationDiverged, match=r"'hover' 1e\+200, no number within 1e\+150, at step 1"):
        score_rollout(huge, by_script["hover"])


def test_numbers_for_each_joint_are_an_error(by_script):
    """One an arm is what a reward pays."""
    with refused("return one number an arm"):
        score_rollout(Paying(lambda step: -(step.action**2)), by_script["finish"])
