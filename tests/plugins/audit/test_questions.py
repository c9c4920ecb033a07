"""Payoffs: who earns what, and whether not finishing pays more than finishing."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.random import default_rng

from harness.eta import Estimate
from harness.payoff.rollout import (
    finishing_of,
    payoff_of,
    score_rollout,
    temptations,
)
from harness.results.recordings.episodes import Episodes
from harness_plugins.audit.questions import deciding_measure, on_best, rank_success
from harness_plugins.audit.recorded.earned import Earned
from tests.payoff.conftest import BASELINE, RELATIVE, Paying, named, potential


@pytest.fixture
def scores(rollouts):
    """Score all rollouts under a reward, perhaps a function of a step."""

    def of(reward):
        reward = Paying(reward) if hasattr(reward, "__name__") else reward
        return [score_rollout(reward, rollout) for rollout in rollouts]

    return of


def test_finish_by_hand(scores, by_script):
    """Under the baseline an episode that only comes nearer is paid Bd - d(t) at every step, and its events."""
    finish = by_script["finish"]
    gained = np.where(finish.running, finish.distances[0] - finish.distances[1:], 0.0)
    payoff = payoff_of(scores(BASELINE)[0], 0.95)
    paid, weights = gained + finish.events, 0.95 ** np.arange(len(gained))[:, None]
    expected = [of.sum(axis=0).mean() for of in (gained, paid, weights * paid)]
    assert [payoff.shaped, payoff.total, payoff.total_discounted] == pytest.approx(expected)
    assert (payoff.policy, payoff.success, payoff.steps) == ("finish", 1.0, finish.steps.mean())
    assert "terms" not in payoff.to_json()


@pytest.mark.parametrize("gamma", [1.0, 0.95])
@pytest.mark.parametrize("name", ["baseline", "arp:k2=2"])
def test_not_finishing_pays_under_baseline_and_arp(scores, name, gamma):
    """Both keep paying for what was gained once, and the target ends it: hovering and creeping earn more."""
    tempting = temptations(scores(named(name)), gamma)
    found = {temptation.policy: temptation for temptation in tempting}
    assert {"hover", "creep"} <= found.keys()
    assert found["hover"].margin > 0.0
    assert found["hover"].share > 0.9
    earned = [temptation.earns for temptation in tempting]
    assert earned == sorted(earned, reverse=True)


@pytest.mark.parametrize("gamma", [1.0, 0.95])
def test_nothing_tempts_under_the_relative_reward_and_a_potential(scores, gamma):
    """A bounded share of the distance gained pays finishing most, and so does shaping with the learner's discount."""
    assert temptations(scores(RELATIVE), gamma) == []
    assert temptations(scores(potential(gamma)), gamma) == []


def test_a_tie_is_no_temptation(rollouts):
    """A policy that earns the same as finishing is none."""
    nothing = Paying(lambda sample: 0.0 * sample.distance)
    unpaid = [replace(rollout, events=0.0 * rollout.events) for rollout in rollouts]
    assert temptations([score_rollout(nothing, rollout) for rollout in unpaid], 1.0) == []


HOLDING = {
    "Bd - d is 0 at the start": (lambda step: step.begin_distance - step.distance, False),
    "a bonus per step pays for lasting": (lambda step: 0.1 + 0.0 * step.distance, True),
    "rounding is no pay": (lambda step: np.where(step.distance < step.begin_distance, 1.0, 1e-9), False),
}


@pytest.mark.parametrize(("reward", "pays"), HOLDING.values(), ids=HOLDING)
def test_whether_holding_still_pays(scores, reward, pays):
    """A return that is tiny beside the others' does not count."""
    assert finishing_of(scores(reward), 0.95).holding_pays == pays


def test_scaling_the_reward_scales_the_shaped_return(scores):
    """Three times the reward, three times the shaped return; the events stay."""
    tripled = scores(lambda sample: 3.0 * BASELINE((), sample)[1])
    for one, three in zip(scores(BASELINE), tripled, strict=True):
        first, second = payoff_of(one, 0.95), payoff_of(three, 0.95)
        assert second.shaped == pytest.approx(3.0 * first.shaped)
        assert second.total - second.shaped == pytest.approx(first.total - first.shaped)


def test_terms_are_summed_over_an_episode(scores):
    """Their means add up to the shaped return."""
    payoff = payoff_of(scores(lambda step: {"reach": -step.distance, "bonus": 0.5 + 0.0 * step.distance})[0], 0.95)
    assert payoff.terms["bonus"] == pytest.approx(0.5 * payoff.steps)
    assert sum(payoff.terms.values()) == pytest.approx(payoff.shaped)
    assert payoff.to_json()["terms"] == payoff.terms


def test_a_term_that_never_pays_is_told(scores, by_script):
    """It pays 0 in every step of every script; one that pays in a single step does."""
    last = by_script["random"].distances.max()
    reward = scores(lambda step: {
        "reach": -step.distance, "dock": 1.0 * (step.distance < -1.0), "farthest": 1.0 * (step.distance == last)
    })  # fmt: skip
    assert [finishing_of(it, 0.95).never_paid for it in (reward, scores(BASELINE))] == [("dock",), ()]


def test_finishing_is_told_in_one_answer(scores):
    """Policies by return, what tempts with a discount and without, and in how many steps that was found."""
    paid = scores(BASELINE)
    found = finishing_of(paid, 0.95)
    assert found.payoffs == tuple(sorted((payoff_of(it, 0.95) for it in paid), key=lambda it: -it.total))
    assert (list(found.undiscounted), list(found.discounted)) == (temptations(paid, 1.0), temptations(paid, 0.95))
    assert found.steps == sum(int(it.rollout.steps.sum()) for it in paid)


def episodes(paid, **measures):
    """Of one training."""
    values = {name: np.asarray(of, float) for name, of in measures.items()}
    return Episodes(np.arange(len(paid)), {"a": np.asarray(paid, float)}, values, {})


def test_pairs_of_a_success_and_a_failure_are_counted():
    """Over all trainings; an episode of which nobody knows whether it succeeded is left out."""
    rng = default_rng(0)
    each = [episodes(rng.normal(size=6), success=rng.integers(2, size=6)) for _ in range(4)]
    each.append(episodes([100.0, -100.0], success=[np.nan, 1.0]))
    paid = np.concatenate([it.returns["a"] for it in each])
    reached = np.concatenate([it.behaviour["success"] for it in each])
    wins = paid[reached == 1.0][:, None] > paid[reached == 0.0]
    found = rank_success(each, "a", "success")
    assert (found.value, found.above, found.below) == (pytest.approx(wins.mean()), *wins.shape)


@pytest.mark.parametrize(
    ("measures", "name"),
    [
        ({"done": [0.0, 1.0], "success": [1.0, 0.0]}, "success"),
        ({"arm": [0.5, 1.0], "done": [0.0, 1.0]}, "done"),
        ({"success": [0.5, 1.0]}, ""),
        ({}, ""),
    ],
)
def test_measure_of_success_is_0_or_1(measures, name):
    """The one of this name, if it is."""
    assert deciding_measure([episodes([1.0, 2.0], **measures)]) == name


def behaviour(name, success, paid):
    """With intervals of the width 0.1."""
    return Earned(name, 9, {"a": Estimate(paid)}, {"s": Estimate(success, success - 0.05, success + 0.05, 3)})


GOOD, BAD = behaviour("good", 0.9, 1.0), behaviour("bad", 0.2, 5.0)


@pytest.mark.parametrize(
    ("rows", "line"),
    [
        ((GOOD, BAD), "for: bad (s 0.2). What succeeds most is another behaviour: good (0.9)."),
        (
            (GOOD, BAD, behaviour("near", 0.85, 7.0)),
            "for: near (s 0.85). What succeeds most is another behaviour: good (0.9), which may be chance.",
        ),
        ((GOOD, behaviour("worse", 0.1, 0.0)), "for what succeeds most: good (s 0.9)."),
        ((GOOD,), None),
    ],
)
def test_reward_that_pays_most_for_another_behaviour_is_named(rows, line):
    """It may be chance where intervals of success overlap; one behaviour alone, or no success, says nothing."""
    assert on_best(rows, ["a"], "s") == ([f"a pays most {line}"] if line else [])
    assert on_best(rows, ["a"], "") == []


def test_two_evaluations_of_a_training_are_one_in_intervals():
    """Four trainings that were evaluated twice are no eight: the interval is over four."""
    rng = default_rng(1)
    each = [episodes(rng.normal(size=6), success=[0.0, 1.0] * 3) for _ in range(4)]
    twice = [it for it in each for _ in range(2)]
    found, alone = rank_success(twice, "a", "success", [0, 0, 1, 1, 2, 2, 3, 3]), rank_success(each, "a", "success")
    assert (found.clusters, found.value) == (4, pytest.approx(alone.value))
    assert (found.low, found.high) == (pytest.approx(alone.low, abs=0.02), pytest.approx(alone.high, abs=0.02))
    eight = rank_success(twice, "a", "success")
    assert found.high - found.low > eight.high - eight.low
