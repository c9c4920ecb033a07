"""Payoffs: who earns what, and whether not finishing pays more than finishing."""

from dataclasses import replace

import numpy as np
import pytest

from harness.audit.questions import holding_pays, never_paid, payoff_of, temptations
from harness.audit.score import score_rollout
from harness_plugins.rewards.arp import Arp
from harness_plugins.rewards.baseline import Baseline


@pytest.fixture
def scores(rollouts):
    """Score all rollouts under a reward."""
    return lambda reward: [score_rollout(reward, rollout) for rollout in rollouts]


def test_finish_by_hand(scores, by_script):
    """Under the baseline an episode that only comes nearer is paid Bd - d(t) at every step, and its events."""
    finish = by_script["finish"]
    gained = np.where(finish.running, finish.distances[0] - finish.distances[1:], 0.0)
    payoff = payoff_of(scores(Baseline())[0], 0.95)
    assert payoff.shaped == pytest.approx(gained.sum(axis=0).mean())
    assert payoff.total == pytest.approx((gained + finish.events).sum(axis=0).mean())
    weights = 0.95 ** np.arange(len(gained))[:, None]
    assert payoff.total_discounted == pytest.approx((weights * (gained + finish.events)).sum(axis=0).mean())
    assert (payoff.policy, payoff.success, payoff.steps) == ("finish", 1.0, finish.steps.mean())


@pytest.mark.parametrize("gamma", [1.0, 0.95])
@pytest.mark.parametrize("reward", [Baseline(), Arp(k2=2.0)], ids=["baseline", "arp"])
def test_not_finishing_pays_under_baseline_and_arp(scores, reward, gamma):
    """Both keep paying for what was gained once, and the target ends it: hovering and creeping earn more."""
    found = {temptation.policy: temptation for temptation in temptations(scores(reward), gamma)}
    assert {"hover", "creep"} <= found.keys()
    assert found["hover"].margin > 0.0
    assert found["hover"].share > 0.9


@pytest.mark.parametrize("gamma", [1.0, 0.95])
def test_nothing_tempts_under_the_relative_reward(scores, toolbox, gamma):
    """A bounded share of the distance gained pays finishing most."""
    assert temptations(scores(toolbox.relative), gamma) == []


@pytest.mark.parametrize("gamma", [1.0, 0.95])
def test_nothing_tempts_under_a_potential_with_the_learners_discount(scores, toolbox, gamma):
    """Potential-based shaping leaves finishing what pays most."""
    assert temptations(scores(toolbox.potential(gamma)), gamma) == []


def test_the_best_temptation_comes_first(scores):
    """They are in the order of what they earn."""
    earned = [temptation.earns for temptation in temptations(scores(Baseline()), 1.0)]
    assert earned == sorted(earned, reverse=True)
    assert len(earned) > 1


def test_a_tie_is_no_temptation(rollouts, toolbox):
    """A policy that earns the same as finishing is none."""
    nothing = toolbox.paying(lambda sample: 0.0 * sample.distance)
    unpaid = [replace(rollout, events=0.0 * rollout.events) for rollout in rollouts]
    assert temptations([score_rollout(nothing, rollout) for rollout in unpaid], 1.0) == []


def test_holding_still_does_not_pay_under_the_baseline(scores):
    """Bd - d is 0 at the start."""
    assert not holding_pays([payoff_of(score, 0.95) for score in scores(Baseline())])


def test_holding_still_pays_under_a_bonus_per_step(scores, toolbox):
    """A constant above 0 pays for lasting."""
    bonus = toolbox.paying(lambda sample: 0.1 + 0.0 * sample.distance)
    assert holding_pays([payoff_of(score, 0.95) for score in scores(bonus)])


def test_rounding_is_no_pay(scores, toolbox):
    """A return of hold that is tiny beside the others' does not count."""
    tiny = toolbox.paying(lambda sample: np.where(sample.distance < sample.begin_distance, 1.0, 1e-9))
    assert not holding_pays([payoff_of(score, 0.95) for score in scores(tiny)])


def test_scaling_the_reward_scales_the_shaped_return(scores, toolbox):
    """Three times the reward, three times the shaped return; the events stay."""
    tripled = toolbox.paying(lambda sample: 3.0 * Baseline()((), sample)[1])
    for one, three in zip(scores(Baseline()), scores(tripled), strict=True):
        first, second = payoff_of(one, 0.95), payoff_of(three, 0.95)
        assert second.shaped == pytest.approx(3.0 * first.shaped)
        assert second.total - second.shaped == pytest.approx(first.total - first.shaped)


def test_terms_are_summed_over_an_episode(scores, toolbox):
    """Their means add up to the shaped return; a reward without terms has none, in the plain data neither."""
    reward = toolbox.paying(lambda step: {"reach": -step.distance, "bonus": 0.5 + 0.0 * step.distance})
    payoff = payoff_of(scores(reward)[0], 0.95)
    assert payoff.terms["bonus"] == pytest.approx(0.5 * payoff.steps)
    assert sum(payoff.terms.values()) == pytest.approx(payoff.shaped)
    assert payoff.to_json()["terms"] == payoff.terms
    assert "terms" not in payoff_of(scores(Baseline())[0], 0.95).to_json()


def test_a_term_that_never_pays_is_told(scores, toolbox):
    """It pays 0 in every step of every script; one that pays in a single step does."""
    by_script = {score.rollout.script: score for score in scores(Baseline())}
    last = by_script["random"].rollout.distances.max()
    reward = toolbox.paying(
        lambda step: {
            "reach": -step.distance,
            "dock": 1.0 * (step.distance < -1.0),
            "farthest": 1.0 * (step.distance == last),
        }
    )
    assert never_paid(scores(reward)) == ("dock",)
    assert never_paid(scores(Baseline())) == ()
