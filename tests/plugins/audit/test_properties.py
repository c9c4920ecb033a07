"""Properties: rewards whose answers are known."""

import numpy as np
import pytest

from harness.payoff.score import score_rollout
from harness.registry.choice import choose
from harness.registry.registry import load_registry
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
from harness_plugins.rewards.arp import Arp
from harness_plugins.rewards.baseline import Baseline

REGISTRY = load_registry()


@pytest.fixture(scope="module")
def tried(rollouts):
    """Recorded and made-up distances."""
    return [*(rollout.distances for rollout in rollouts), probe_distances(0.05, 1.5)]


def test_probes_stay_between_their_ends():
    """Made-up distances are within the given ones, and use them."""
    distances = probe_distances(0.01, 2.0)
    assert distances.min() >= 0.01
    assert distances.max() <= 2.0
    assert distances.min() < 0.02
    assert distances.max() > 1.8


def test_a_third_of_the_probes_only_comes_nearer():
    """Rewards that answer to improvements in a row meet some."""
    assert (np.diff(probe_distances(0.05, 1.5)[:, -16:], axis=0) < 0.0).all()


def test_the_relative_gain_is_bounded(toolbox):
    """No share of the larger distance exceeds 1."""
    answer = bounded(toolbox.relative)
    assert answer.holds
    assert "no counter-example" in answer.evidence
    assert "|r| <= 1" in answer.evidence


def test_dividing_by_the_distance_has_no_bound_near_the_target(toolbox):
    """Eq. 30 to the letter grows without end as distances shrink."""
    literal = toolbox.paying(lambda sample: (sample.previous_distance - sample.distance) / sample.distance)
    answer = bounded(literal)
    assert not answer.holds
    assert "shrink" in answer.evidence


@pytest.mark.parametrize("reward", [Baseline(), Arp()], ids=["baseline", "arp"])
def test_metres_have_no_bound(reward):
    """A reward in metres grows with the distances, and only with them."""
    answer = bounded(reward)
    assert not answer.holds
    assert "grow from 1e3" in answer.evidence
    assert "shrink" not in answer.evidence


def test_what_is_remembered_may_grow_with_the_episode(toolbox):
    """A count of improvements is unbounded because an episode may be long."""
    answer = bounded(toolbox.counting())
    assert not answer.holds
    assert "2,000 steps" in answer.evidence


def test_a_logarithm_has_no_bound(toolbox):
    """Slow growth is growth."""
    assert not bounded(toolbox.paying(lambda sample: np.log(sample.distance))).holds


def test_infinity_is_no_bound(toolbox):
    """A reward that overflows is not bounded, and the text says how."""
    answer = bounded(toolbox.paying(lambda sample: np.exp(sample.distance)))
    assert not answer.holds
    assert "beyond every number" in answer.evidence


def test_the_relative_gain_is_scale_free(toolbox, tried):
    """Scaling all distances changes no share."""
    assert scale_free(toolbox.relative, tried).holds


@pytest.mark.parametrize("reward", [Baseline(), Arp()], ids=["baseline", "arp"])
def test_metres_scale_in_proportion(reward, tried):
    """Baseline and ARP pay c times as much when distances are c times as large."""
    answer = scale_free(reward, tried)
    assert not answer.holds
    assert "in proportion" in answer.evidence


def test_a_square_is_neither(toolbox, tried):
    """A squared distance is neither unchanged nor in proportion."""
    answer = scale_free(toolbox.paying(lambda sample: -(sample.distance**2)), tried)
    assert not answer.holds
    assert "neither" in answer.evidence


@pytest.mark.parametrize("gamma", [0.95, 1.0])
def test_a_potential_is_recognised(toolbox, tried, gamma):
    """Shaping by gamma phi(d') - phi(d) is potential-based at its own discount."""
    answer = potential_based(toolbox.potential(gamma), tried, gamma)
    assert answer.holds
    assert answer.gamma == gamma


def test_a_curved_potential_is_recognised(toolbox, tried):
    """Whatever phi is, as long as it vanishes at the target."""
    assert potential_based(toolbox.potential(0.95, lambda d: -np.tanh(3.0 * d) * d), tried, 0.95).holds


def test_a_potential_of_the_begin_distance_is_recognised(toolbox, tried):
    """It may be one of the whole state: here of the share of the begin distance that is left."""
    share = toolbox.paying(lambda sample: (sample.previous_distance - sample.distance) / sample.begin_distance)
    assert potential_based(share, tried, 1.0).holds


def test_a_potential_of_the_best_distance_is_recognised(toolbox, tried):
    """Paying each improvement of the best once telescopes as well."""
    best = toolbox.paying(lambda sample: np.maximum(-sample.delta_distance, 0.0))
    assert potential_based(best, tried, 1.0).holds


def test_a_potential_with_another_discount_is_named_with_its_own(toolbox, tried):
    """Shaped for 0.99, a learner with 0.95 is told that it is not covered."""
    answer = potential_based(toolbox.potential(0.99), tried, 0.95)
    assert answer.gamma == 0.99
    assert "does not hold for a learner that discounts by 0.95" in answer.evidence


def test_a_constant_on_top_is_not_policy_invariant(toolbox, tried):
    """Episodes end early: what is paid per step counts, and the text says how much it is."""
    shifted = toolbox.paying(lambda sample: 0.1 + sample.previous_distance - 0.95 * sample.distance)
    answer = potential_based(shifted, tried, 0.95)
    assert not answer.holds
    assert "each step at the target pays 0.1" in answer.evidence


@pytest.mark.parametrize("gamma", [0.95, 1.0])
def test_other_rewards_are_not_potential_based(toolbox, tried, gamma):
    """Baseline, ARP, the negative distance and the relative gain depend on the way."""
    for reward in (Baseline(), Arp(), toolbox.dense, toolbox.relative):
        answer = potential_based(reward, tried, gamma)
        assert not answer.holds
        assert answer.gamma is None


def test_the_way_taken_is_told(tried):
    """Under the baseline two ways between the same states are paid very differently."""
    assert worst_detour(Baseline(), tried, 1.0) > 0.5


def test_the_fit_explains_a_potential(toolbox, tried):
    """Least squares finds phi = -d and its discount."""
    fit = fit_potential(toolbox.potential(0.97), tried, 0.97)
    assert fit.explained == pytest.approx(1.0)
    assert fit.own_gamma == pytest.approx(0.97)


def test_the_fit_does_not_explain_the_baseline(tried):
    """No phi of the distance comes near."""
    assert fit_potential(Baseline(), tried, 0.95).explained < 0.5


def test_standing_on_the_target_is_free_under_a_potential(toolbox):
    """Its potential is 0 there; the baseline pays what was gained since the start."""
    assert waiting_at_target(toolbox.potential(0.95)) == 0.0
    assert waiting_at_target(Baseline()) == 0.5


def test_nothing_paid_has_every_property(toolbox, rollouts):
    """The reward that is always 0 is bounded, scale-free and potential-based."""
    nothing = toolbox.paying(lambda sample: 0.0 * sample.distance)
    assert all(answer.holds for answer in properties_of(nothing, [rollouts[0].distances], 0.95))


@pytest.mark.parametrize("name", REGISTRY.names("rewards"))
def test_every_reward_gets_an_answer(name, rollouts):
    """Whatever is registered is answered three times, with evidence."""
    reward = choose(REGISTRY, "rewards", name).build(REGISTRY, "rewards")
    answers = properties_of(reward, [rollout.distances for rollout in rollouts], 0.95)
    assert [answer.name for answer in answers] == ["bounded", "scale-free", "potential-based"]
    assert all(answer.evidence for answer in answers)


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


@pytest.mark.parametrize("name", [name for name in KNOWN if name.split(":")[0] in REGISTRY.names("rewards")])
def test_descriptions_and_audit_agree(name, rollouts):
    """What a reward says of itself is what is found."""
    reward = choose(REGISTRY, "rewards", name).build(REGISTRY, "rewards")
    bound, scale, potential = properties_of(reward, [rollout.distances for rollout in rollouts], 0.95)
    assert (bound.holds, scale.holds, potential.gamma) == KNOWN[name]


def test_a_reward_that_needs_more_is_not_asked(toolbox, rollouts):
    """Made-up distances have no action; each answer says so."""
    reward = toolbox.paying(lambda step: -(step.action**2).sum(-1))
    needed = needed_beside_distances(reward, [score_rollout(reward, rollout) for rollout in rollouts])
    answers = properties_of(reward, [rollout.distances for rollout in rollouts], 0.95, needed)
    assert [answer.name for answer in answers] == ["bounded", "scale-free", "potential-based"]
    for answer in answers:
        assert answer.holds is None
        assert answer.evidence == "not asked: it reads action, which made-up distances do not have"


READERS = {
    "distances": (lambda step: step.distance - step.before.distance + step.previous_best, ()),
    "unpacked": (lambda step: step[0] + sum(step), ()),
    "copied": (lambda step: step._replace(distance=2.0 * step.distance).distance, ()),
    "action before": (lambda step: step.distance - step.before.action[:, 0], ("action",)),
    "in time": (lambda step: step.distance if step.step[0] < 30 else step.qvel[:, 2], ("qvel",)),
    "if there": (lambda step: -getattr(step, "qpos", step.distance[:, None])[:, 0], ("qpos",)),
    "two": (lambda step: step.end_effector[:, 2] - 1.0 * step.ground, ("end_effector", "ground")),
}


@pytest.mark.parametrize(("pays", "needed"), READERS.values(), ids=READERS)
def test_what_a_reward_needs_beside_distances_is_found(toolbox, rollouts, pays, needed):
    """By leaving it out: who unpacks or copies steps needs no more, and who looks late or with care does."""
    reward = toolbox.paying(pays)
    assert needed_beside_distances(reward, [score_rollout(reward, rollout) for rollout in rollouts]) == needed
