"""The whole audit: what it says of rewards, in numbers and in words."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from harness.errors import SimulationDiverged
from harness.reward.forms import reward_class
from harness.text import number
from harness_plugins.audit import audit_reward
from tests.payoff.conftest import BASELINE, REGISTRY, RELATIVE, Paying, named, potential

FAIR = ("relative", "potential", "adaptive", "sparse", "dense")


@pytest.fixture(scope="module")
def judge(rollouts):
    """Audit a reward, perhaps by its name or as a function of steps, against the baseline; each once."""

    @cache
    def audited(reward):
        made = reward
        if isinstance(reward, str):
            made = named(reward)
        elif hasattr(reward, "__name__"):
            made = reward_class(reward)()
        return audit_reward(made, BASELINE, rollouts, 0.95)

    return audited


@pytest.mark.parametrize("name", ["baseline", "arp"])
def test_the_verdict_warns_of_not_finishing(judge, name):
    """Baseline and ARP pay not finishing more, and the first line says so with both figures."""
    found = judge(name)
    payoffs = found.scripts.finishing.payoffs
    best, finish = payoffs[0], next(payoff for payoff in payoffs if payoff.policy == "finish")
    line = found.verdict[0]
    assert line.startswith("Not finishing pays more than finishing: ")
    assert f"{best.policy} earns {number(best.total)} per episode, finish {number(finish.total)}" in line


def test_the_verdict_is_in_lines(judge):
    """Good; judged by the learner's discount, that takes back that holding pays; and warned of twice."""
    (good,) = judge(RELATIVE).verdict
    assert good.startswith("Finishing pays most: ")
    finishing, holding = judge(potential(0.95)).verdict[:2]
    assert finishing.startswith("Finishing pays most")
    assert holding.startswith("Holding still pays")
    assert "the discount takes it back" in holding
    tempts, holding = judge(Paying(lambda sample: 0.2 + 0.0 * sample.distance)).verdict[:2]
    assert tempts.startswith("Not finishing pays more")
    assert holding.startswith("Holding still pays")
    assert "takes it back" not in holding


def test_scripts_that_miss_their_aim_are_named(rollouts):
    """Where finish does not arrive, or hover does, the verdict says how often."""
    spoilt = {"finish": np.arange(12) < 6, "hover": np.arange(12) < 3}
    mixed = [replace(run, reached=spoilt.get(run.script, run.reached)) for run in rollouts]
    lines = audit_reward(BASELINE, BASELINE, mixed, 0.95).verdict
    assert "finish reached the target in only 50% of the episodes." in lines
    assert any(line.startswith("hover could not stay outside epsilon: 25%") for line in lines)


def test_a_larger_workspace_pays_metres_in_proportion(judge):
    """All returns of the baseline double with the distances, where 0 has no ratio; the relative gain pays the same."""
    ratios = dict(judge("baseline").scripts.workspace)
    assert ratios.pop("hold") is None
    assert list(ratios.values()) == pytest.approx([2.0] * len(ratios))
    ratios = judge(RELATIVE).scripts.workspace
    assert [ratios[name] for name in ("finish", "hover", "random")] == pytest.approx([1.0] * 3)


@pytest.mark.parametrize("name", REGISTRY.names("rewards"))
def test_every_reward_can_be_audited(judge, name):
    """Each gives plain data with finite numbers, and a verdict; no script earns more than finishing under fair ones."""
    found = judge(name)
    data = json.loads(json.dumps(found.to_json(), allow_nan=False))
    assert data["best"] == data["policies"][0]["policy"]
    assert data["properties"].keys() == {"bounded", "scale_free", "potential_based"}
    assert found.verdict
    assert name not in FAIR or found.scripts.finishing.discounted == ()


def test_both_distances_are_written(judge):
    """EPIC's under its old name, DARD's beside it; they are not the same number. ARP is no rescaling."""
    found = judge("arp")
    data, pair = found.to_json(), found.pairs[0]
    epic, dard = (pair.forms[name].value for name in ("EPIC", "DARD"))
    assert data["distance"] == {"value": epic, "transitions": found.scripts.compared}
    assert data["reachable_distance"]["value"] == dard
    assert 0.0 < dard < epic
    assert pair.rescaling is data["rescaled"] is None


def test_the_other_reward_must_be_finite_too(rollouts):
    """A reward to compare with that pays NaN is an error, not a distance."""
    broken = Paying(lambda sample: np.nan * sample.distance)
    with pytest.raises(SimulationDiverged):
        audit_reward(BASELINE, broken, rollouts, 0.95)


@pytest.mark.parametrize(
    ("name", "factor", "offset"),
    [("scaled:factor=3", 3.0, 0.0), ("shifted:offset=-0.5", 1.0, -0.5), ("baseline", 1.0, 0.0)],
)
def test_a_reward_that_is_another_but_for_its_scale_is_recognised(judge, rollouts, name, factor, offset):
    """In every step of the scripted policies."""
    found = judge(name)
    line = found.pairs[0].rescaling
    steps = sum(int(rollout.running.sum()) for rollout in rollouts)
    assert (line.factor, line.offset, line.steps) == (pytest.approx(factor), pytest.approx(offset), steps)
    assert found.to_json()["rescaled"]["steps"] == steps


def test_a_reward_of_more_than_distances_is_told_in_plain_data(judge):
    """Its terms and what never paid; the others have no such words."""

    def terms(step):
        return {"reach": -step.distance, "effort": -(step.action**2).sum(-1), "none": 0.0 * step.distance}

    data = json.loads(json.dumps(judge(terms).to_json(), allow_nan=False))
    assert data["policies"][0]["terms"].keys() == {"reach", "effort", "none"}
    assert data["never_paid"] == ["none"]
    assert 0.0 < data["starc_distance"]["value"] < 1.0
    assert {answer["holds"] for answer in data["properties"].values()} == {None}
    assert set(data["workspace_twice_as_large"].values()) == {None}
    plain = judge("arp").to_json()
    assert "never_paid" not in plain
    assert "terms" not in plain["policies"][0]


def test_a_reward_of_distances_with_terms_is_asked_about_made_up_ones(judge):
    """As any other of its kind; and it is what the sum of its terms is."""

    def two(step):
        return {"begin": step.begin_distance, "now": -step.distance}

    def one(step):
        return step.begin_distance - step.distance

    found, same = map(judge, (two, one))
    assert found.scripts.properties == same.scripts.properties
    assert found.pairs[0].forms == same.pairs[0].forms
