"""Properties: rewards whose answers are known."""

import numpy as np
import pytest
from numpy.random import default_rng

from harness.payoff.rollout import score_rollout
from harness_plugins.audit.probe import needed_beside_distances, probe_distances
from harness_plugins.audit.properties import (
    bounded,
    fit_potential,
    potential_based,
    properties_of,
    scale_free,
    waiting_at_target,
    worst_detour,
)
from tests.payoff.conftest import ARP, BASELINE, DENSE, REGISTRY, RELATIVE, Counting, Paying, named, potential


@pytest.fixture(scope="module")
def tried(rollouts):
    """Recorded and made-up distances."""
    return [*(rollout.distances for rollout in rollouts), probe_distances(0.05, 1.5)]


def of(it):
    """A reward, perhaps by what it pays."""
    return Paying(it) if hasattr(it, "__name__") else it


def test_probes_stay_between_their_ends():
    """Made-up distances are within the given ones, and use them. A third only comes nearer, in a row."""
    distances = probe_distances(0.01, 2.0)
    assert 0.01 <= distances.min() < 0.02
    assert 1.8 < distances.max() <= 2.0
    assert (np.diff(distances[:, -16:], axis=0) < 0.0).all()


BOUNDED = {
    "no share of the larger distance exceeds 1": (RELATIVE, True, "no counter-example"),
    "the bound is told": (RELATIVE, True, "|r| <= 1"),
    "eq. 30 to the letter grows without end as distances shrink": (
        lambda step: (step.previous_distance - step.distance) / step.distance, False, "shrink"
    ),
    "the baseline grows with the distances": (BASELINE, False, "grow from 1e3"),
    "so does ARP": (ARP, False, "grow from 1e3"),
    "slow growth is growth": (lambda step: np.log(step.distance), False, ""),
    "what overflows is not bounded": (lambda step: np.exp(step.distance), False, "beyond every number"),
}  # fmt: skip


@pytest.mark.parametrize(("reward", "holds", "told"), BOUNDED.values(), ids=BOUNDED)
def test_bounded(reward, holds, told):
    """With evidence; metres have no bound, and only as they grow."""
    answer = bounded(of(reward))
    assert (answer.holds, told in answer.evidence) == (holds, True)
    assert reward not in (BASELINE, ARP) or "shrink" not in answer.evidence


def test_what_is_remembered_may_grow_with_the_episode():
    """A count of improvements is unbounded because an episode may be long."""
    answer = bounded(Counting())
    assert (answer.holds, "2,000 steps" in answer.evidence) == (False, True)


@pytest.mark.parametrize(
    ("reward", "holds", "told"),
    [
        (RELATIVE, True, ""),
        (BASELINE, False, "in proportion"),
        (ARP, False, "in proportion"),
        (lambda step: -(step.distance**2), False, "neither"),
    ],
)
def test_scale_free(tried, reward, holds, told):
    """Scaling all distances changes no share; baseline and ARP pay c times as much, a square neither."""
    answer = scale_free(of(reward), tried)
    assert (answer.holds, told in answer.evidence) == (holds, True)


POTENTIALS = {
    "any that is 0 at the target": (lambda step, phi: 0.95 * phi(step.distance) - phi(step.previous_distance), 0.95),
    "of the begin distance: the share that is left": (
        lambda step, _: (step.previous_distance - step.distance) / step.begin_distance, 1.0
    ),
    "of the best distance: each improvement is paid once": (lambda step, _: np.maximum(-step.delta_distance, 0.0), 1.0),
}  # fmt: skip


@pytest.mark.parametrize(("pays", "gamma"), POTENTIALS.values(), ids=POTENTIALS)
def test_a_potential_is_recognised(tried, pays, gamma):
    """Whatever phi is, of the whole state."""
    assert potential_based(of(lambda step: pays(step, lambda d: -np.tanh(3.0 * d) * d)), tried, gamma).holds


def test_a_potential_with_another_discount_is_named_with_its_own(tried):
    """Shaped for 0.99, a learner with 0.95 is told that it is not covered; at its own discount it holds."""
    answer = potential_based(potential(0.99), tried, 0.95)
    assert answer.gamma == 0.99
    assert "does not hold for a learner that discounts by 0.95" in answer.evidence
    for gamma in (0.95, 1.0):
        answer = potential_based(potential(gamma), tried, gamma)
        assert (answer.holds, answer.gamma) == (True, gamma)


def test_a_constant_on_top_is_not_policy_invariant(tried):
    """Episodes end early: what is paid per step counts, and the text says how much it is."""
    answer = potential_based(of(lambda step: 0.1 + step.previous_distance - 0.95 * step.distance), tried, 0.95)
    assert not answer.holds
    assert "each step at the target pays 0.1" in answer.evidence


@pytest.mark.parametrize("gamma", [0.95, 1.0])
def test_other_rewards_are_not_potential_based(tried, gamma):
    """Baseline, ARP, the negative distance and the relative gain depend on the way."""
    for reward in (BASELINE, ARP, DENSE, RELATIVE):
        answer = potential_based(reward, tried, gamma)
        assert (answer.holds, answer.gamma) == (False, None)


def test_the_fit_explains_a_potential_and_not_the_baseline(tried):
    """Least squares finds phi = -d and its discount. Two ways between the same states are paid very differently."""
    fit = fit_potential(potential(0.97), tried, 0.97)
    assert (fit.explained, fit.own_gamma) == (pytest.approx(1.0), pytest.approx(0.97))
    assert fit_potential(BASELINE, tried, 0.95).explained < 0.5
    assert worst_detour(BASELINE, tried, 1.0) > 0.5


def test_standing_on_the_target_is_free_under_a_potential():
    """Its potential is 0 there; the baseline pays what was gained since the start."""
    assert (waiting_at_target(potential(0.95)), waiting_at_target(BASELINE)) == (0.0, 0.5)


def test_nothing_paid_has_every_property(rollouts):
    """The reward that is always 0 is bounded, scale-free and potential-based."""
    nothing = of(lambda step: 0.0 * step.distance)
    assert all(answer.holds for answer in properties_of(nothing, [rollouts[0].distances], 0.95))


KNOWN = {  # what the rewards' own descriptions say: bounded, scale-free, discount at which potential-based
    "adaptive": (True, True, 1.0),
    "dense": (False, False, None),
    "potential": (False, False, 0.95),
    "potential:gamma=1": (False, False, 1.0),
    "relative": (True, True, None),
    "relative:denominator=current": (False, False, None),
    "shifted:reward=potential": (False, False, None),
    "sparse": (True, True, 0.95),
}


@pytest.mark.parametrize("name", dict.fromkeys([*REGISTRY.names("rewards"), *KNOWN]))
def test_every_reward_gets_an_answer(name, rollouts):
    """Whatever is registered is answered three times, with evidence; what a reward says of itself is what is found."""
    answers = properties_of(named(name), [rollout.distances for rollout in rollouts], 0.95)
    assert [answer.name for answer in answers] == ["bounded", "scale-free", "potential-based"]
    assert all(answer.evidence for answer in answers)
    bound, scale, shaping = answers
    found = (bound.holds, scale.holds, shaping.gamma)
    assert KNOWN.get(name, found) == found


def test_a_reward_that_needs_more_is_not_asked(rollouts):
    """Made-up distances have no action; each answer says so."""
    reward = of(lambda step: -(step.action**2).sum(-1))
    answers = properties_of(reward, [rollout.distances for rollout in rollouts], 0.95, ("action",))
    told = "not asked: it reads action, which made-up distances do not have"
    assert [(it.name, it.holds, it.evidence) for it in answers] == [
        (name, None, told) for name in ("bounded", "scale-free", "potential-based")
    ]


RNG = default_rng(0)
READERS = {
    "distances": (lambda step: step.distance - step.before.distance + step.previous_best, ()),
    "unpacked": (lambda step: step[0] + sum(step), ()),
    "copied": (lambda step: step._replace(distance=2.0 * step.distance).distance, ()),
    "action before": (lambda step: step.distance - step.before.action[:, 0], ("action",)),
    "in time": (lambda step: step.distance if step.step[0] < 30 else step.qvel[:, 2], ("qvel",)),
    "if there": (lambda step: -getattr(step, "qpos", step.distance[:, None])[:, 0], ("qpos",)),
    "drawn": (lambda step: RNG.normal(size=step.distance.shape) - step.distance, ()),
    "drawn beside an action": (lambda step: RNG.normal(size=step.distance.shape) - step.action[:, 0], ("action",)),
    "two": (lambda step: step.end_effector[:, 2] - 1.0 * step.ground, ("end_effector", "ground")),
}


@pytest.mark.parametrize(("pays", "needed"), READERS.values(), ids=READERS)
def test_what_a_reward_needs_beside_distances_is_found(rollouts, pays, needed):
    """By leaving it out: who unpacks, copies or draws needs no more, and who looks late or with care does."""
    reward = of(pays)
    assert needed_beside_distances(reward, [score_rollout(reward, rollout) for rollout in rollouts]) == needed
