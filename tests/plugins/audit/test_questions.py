"""Payoffs: who earns what, and whether not finishing pays more than finishing."""

from dataclasses import replace

import numpy as np
import pytest

from harness.eta.seed_mean import SeedMean
from harness.payoff.finishing import finishing_of, holding_pays, never_paid, payoff_of, temptations
from harness.payoff.score import score_rollout
from harness.results.recordings.episodes import Episodes
from harness_plugins.audit.questions import deciding_measure, on_best, rank_success
from harness_plugins.audit.recorded.earned import Earned
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


def test_finishing_is_told_in_one_answer(scores):
    """Policies by return, what tempts with a discount and without, and in how many steps that was found."""
    paid = scores(Baseline())
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
    rng = np.random.default_rng(0)
    each = [episodes(rng.normal(size=6), success=rng.integers(2, size=6)) for _ in range(4)]
    each.append(episodes([100.0, -100.0], success=[np.nan, 1.0]))
    paid = np.concatenate([it.returns["a"] for it in each])
    reached = np.concatenate([it.behaviour["success"] for it in each])
    wins = [float(one > other) for one in paid[reached == 1.0] for other in paid[reached == 0.0]]
    found = rank_success(each, "a", "success")
    assert found.value == pytest.approx(np.mean(wins))
    assert (found.above, found.below) == ((reached == 1.0).sum(), (reached == 0.0).sum())


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
    return Earned(name, 9, {"a": SeedMean(paid)}, {"s": SeedMean(success, success - 0.05, success + 0.05, 3)})


def test_reward_that_pays_most_for_another_behaviour_is_named():
    """It may be chance where intervals of success overlap; a single behaviour says nothing."""
    good, bad, near = behaviour("good", 0.9, 1.0), behaviour("bad", 0.2, 5.0), behaviour("near", 0.85, 7.0)
    (line,) = on_best([good, bad], ["a"], "s")
    assert line == "a pays most for: bad (s 0.2). What succeeds most is another behaviour: good (0.9)."
    (line,) = on_best([good, bad, near], ["a"], "s")
    assert line.endswith("good (0.9), which may be chance.")
    (line,) = on_best([good, behaviour("worse", 0.1, 0.0)], ["a"], "s")
    assert line == "a pays most for what succeeds most: good (s 0.9)."
    assert on_best([good], ["a"], "s") == on_best([good, bad], ["a"], "") == []


def test_two_evaluations_of_a_training_are_one_in_intervals():
    """Four trainings that were evaluated twice are no eight: the interval is over four."""
    rng = np.random.default_rng(1)
    each = [episodes(rng.normal(size=6), success=[0.0, 1.0] * 3) for _ in range(4)]
    twice = [it for it in each for _ in range(2)]
    found = rank_success(twice, "a", "success", [number for number in range(4) for _ in range(2)])
    alone = rank_success(each, "a", "success")
    assert (found.clusters, found.value) == (4, pytest.approx(alone.value))
    assert (found.low, found.high) == (pytest.approx(alone.low, abs=0.02), pytest.approx(alone.high, abs=0.02))
    assert found.high - found.low > np.diff([(it := rank_success(twice, "a", "success")).low, it.high])
