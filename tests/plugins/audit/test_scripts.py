"""The whole audit: what it says of rewards, in numbers and in words."""

import json

import numpy as np
import pytest

from harness.errors import SimulationDiverged
from harness.eta.rescaling import Rescaling
from harness.payoff.rollout import Rollout
from harness.payoff.score import score_rollout
from harness.registry.choice import choose
from harness.registry.registry import load_registry
from harness.reward.forms import reward_class
from harness.text import number
from harness_plugins.audit.probe import needed_beside_distances
from harness_plugins.audit.scripts import audit_reward
from harness_plugins.rewards.arp import Arp
from harness_plugins.rewards.baseline import Baseline

REGISTRY = load_registry()
FAIR = ("relative", "potential", "adaptive", "sparse", "dense")


@pytest.fixture(scope="module")
def judge(rollouts):
    """Audit a reward against the baseline."""
    return lambda reward: audit_reward(reward, Baseline(), rollouts, 0.95)


def test_policies_come_by_return(judge):
    """The best first."""
    totals = [payoff.total for payoff in judge(Baseline()).scripts.finishing.payoffs]
    assert totals == sorted(totals, reverse=True)


@pytest.mark.parametrize("reward", [Baseline(), Arp()], ids=["baseline", "arp"])
def test_the_verdict_warns_of_not_finishing(judge, reward):
    """Baseline and ARP pay not finishing more, and the first line says so with both figures."""
    found = judge(reward)
    payoffs = found.scripts.finishing.payoffs
    best, finish = (
        next(payoff for payoff in payoffs if payoff.policy == name) for name in (payoffs[0].policy, "finish")
    )
    line = found.verdict[0]
    assert line.startswith("Not finishing pays more than finishing: ")
    assert f"{best.policy} earns {number(best.total)} per episode, finish {number(finish.total)}" in line


def test_the_verdict_on_the_relative_reward_is_good(judge, toolbox):
    """Finishing pays most, and nothing is warned of."""
    lines = judge(toolbox.relative).verdict
    assert len(lines) == 1
    assert lines[0].startswith("Finishing pays most: ")


def test_a_potential_is_judged_by_its_discount(judge, toolbox):
    """At the learner's discount finishing pays most; that holding pays without is explained."""
    lines = judge(toolbox.potential(0.95)).verdict
    assert lines[0].startswith("Finishing pays most")
    assert lines[1].startswith("Holding still pays")
    assert "the discount takes it back" in lines[1]


def test_a_bonus_per_step_is_warned_of_twice(judge, toolbox):
    """It pays for not finishing, and for holding still."""
    lines = judge(toolbox.paying(lambda sample: 0.2 + 0.0 * sample.distance)).verdict
    assert lines[0].startswith("Not finishing pays more")
    assert lines[1].startswith("Holding still pays")
    assert "takes it back" not in lines[1]


def test_scripts_that_miss_their_aim_are_named(rollouts):
    """Where finish does not arrive, or hover does, the verdict says how often."""
    spoilt = {"finish": np.arange(12) < 6, "hover": np.arange(12) < 3}
    mixed = [
        Rollout(run.script, run.states, run.events, run.running, spoilt.get(run.script, run.reached))
        for run in rollouts
    ]
    lines = audit_reward(Baseline(), Baseline(), mixed, 0.95).verdict
    assert "finish reached the target in only 50% of the episodes." in lines
    assert any(line.startswith("hover could not stay outside epsilon: 25%") for line in lines)


def test_a_larger_workspace_pays_metres_in_proportion(judge):
    """All returns of the baseline double with the distances; what is 0 has no ratio."""
    ratios = dict(judge(Baseline()).scripts.workspace)
    assert ratios.pop("hold") is None
    assert list(ratios.values()) == pytest.approx([2.0] * len(ratios))


def test_a_larger_workspace_leaves_a_scale_free_reward(judge, toolbox):
    """The relative gain pays the same."""
    ratios = judge(toolbox.relative).scripts.workspace
    assert [ratios[name] for name in ("finish", "hover", "random")] == pytest.approx([1.0] * 3)


@pytest.mark.parametrize("name", REGISTRY.names("rewards"))
def test_every_reward_can_be_audited(judge, name):
    """Each gives plain data with finite numbers, and a verdict."""
    found = judge(choose(REGISTRY, "rewards", name).build(REGISTRY, "rewards"))
    data = json.loads(json.dumps(found.to_json(), allow_nan=False))
    assert data["best"] == data["policies"][0]["policy"]
    assert data["properties"].keys() == {"bounded", "scale_free", "potential_based"}
    assert found.verdict


def test_both_distances_are_written(judge):
    """EPIC's under its old name, DARD's beside it; they are not the same number."""
    found = judge(Arp())
    data = found.to_json()
    epic, dard = (found.pairs[0].forms[name].mean for name in ("EPIC", "DARD"))
    assert data["distance"] == {"value": epic, "transitions": found.scripts.finishing.steps}
    assert data["reachable_distance"]["value"] == dard
    assert 0.0 < dard < epic


@pytest.mark.parametrize("name", [name for name in FAIR if name in REGISTRY.names("rewards")])
def test_these_rewards_do_not_tempt(judge, name):
    """At the learner's discount no script earns more than finishing."""
    assert judge(choose(REGISTRY, "rewards", name).build(REGISTRY, "rewards")).scripts.finishing.discounted == ()


def test_the_other_reward_must_be_finite_too(rollouts, toolbox):
    """A reward to compare with that pays NaN is an error, not a distance."""
    broken = toolbox.paying(lambda sample: np.nan * sample.distance)
    with pytest.raises(SimulationDiverged):
        audit_reward(Baseline(), broken, rollouts, 0.95)


@pytest.mark.parametrize(
    ("value", "text"),
    [(41.23, "41.2"), (-0.01, "-0.01"), (1e-17, "0"), (7257.9, "7,258"), (0.0, "0"), (2.5e12, "2.5e+12"), (1.0, "1")],
)
def test_numbers_read_well(value, text):
    """Three digits, no needless exponent."""
    assert number(value) == text


@pytest.mark.parametrize(
    ("name", "factor", "offset"),
    [("scaled:factor=3", 3.0, 0.0), ("shifted:offset=-0.5", 1.0, -0.5), ("baseline", 1.0, 0.0)],
)
def test_a_reward_that_is_another_but_for_its_scale_is_recognised(judge, rollouts, name, factor, offset):
    """In every step of the scripted policies."""
    found = judge(choose(REGISTRY, "rewards", name).build(REGISTRY, "rewards"))
    steps = sum(int(rollout.running.sum()) for rollout in rollouts)
    assert found.pairs[0].rescaling == Rescaling(pytest.approx(factor), pytest.approx(offset), steps, None)
    assert found.to_json()["rescaled"]["steps"] == steps


def test_another_reward_is_no_rescaling(judge):
    """ARP pays gains otherwise than losses."""
    assert judge(Arp()).pairs[0].rescaling is None
    assert judge(Arp()).to_json()["rescaled"] is None


def test_a_reward_of_more_than_distances_is_told_in_plain_data(judge):
    """Its terms, what never paid, and on which fields the distances rest; the others have no such words."""

    def terms(step):
        return {"reach": -step.distance, "effort": -(step.action**2).sum(-1), "none": 0.0 * step.distance}

    data = json.loads(json.dumps(judge(reward_class(terms)()).to_json(), allow_nan=False))
    assert data["policies"][0]["terms"].keys() == {"reach", "effort", "none"}
    assert data["never_paid"] == ["none"]
    assert data["recorded_transitions_because_of"] == ["action"]
    assert 0.0 < data["starc_distance"]["value"] < 1.0
    assert {answer["holds"] for answer in data["properties"].values()} == {None}
    assert set(data["workspace_twice_as_large"].values()) == {None}
    plain = judge(Arp()).to_json()
    assert not {"never_paid", "starc_distance", "recorded_transitions_because_of"} & plain.keys()
    assert "terms" not in plain["policies"][0]


def test_a_reward_of_distances_with_terms_is_asked_about_made_up_ones(judge):
    """As any other of its kind; and it is what the sum of its terms is."""

    def two(step):
        return {"begin": step.begin_distance, "now": -step.distance}

    def one(step):
        return step.begin_distance - step.distance

    found, same = (judge(reward_class(function)()) for function in (two, one))
    assert found.scripts.needed == found.scripts.recorded_because == ()
    assert found.scripts.properties == same.scripts.properties
    assert found.pairs[0].forms == same.pairs[0].forms


def test_the_other_reward_may_read_more(rollouts):
    """Then distances rest on recorded transitions, and properties are asked as ever."""

    def action(step):
        return -(step.action**2).sum(-1)

    found = audit_reward(Baseline(), reward_class(action)(), rollouts, 0.95)
    assert found.scripts.recorded_because == ("action",)
    assert found.scripts.needed == ()
    assert found.scripts.properties == audit_reward(Baseline(), Baseline(), rollouts, 0.95).scripts.properties


@pytest.mark.parametrize(("more", "needed"), [(0.0, ()), (1.0, ("action",))])
def test_a_reward_that_draws_numbers_needs_no_more_than_it_reads(rollouts, more, needed):
    """It pays something else whatever is left out, which says nothing of what it reads."""
    rng = np.random.default_rng(0)

    def noisy(step):
        return rng.normal(size=step.distance.shape) - (more * step.action[:, 0] if more else step.distance)

    reward = reward_class(noisy)()
    assert needed_beside_distances(reward, [score_rollout(reward, it) for it in rollouts]) == needed
