"""How the rewards of an experiment come in all its places."""

import json

import pytest

from harness import load_results
from harness.eta import Estimate
from harness.eta.ranking import Answer
from harness.results.ranking import Ranking, ranking_of
from tests.report.conftest import build_results
from tests.results.folders import fail, load_without

ENGINES = {"mujoco": "MuJoCo", "dm_control": "MuJoCo", "pybullet": "Bullet", "kinematic": None}


def reaching(count):
    """Steps of so many of four episodes."""
    return lambda seed: [8] * count


@pytest.fixture(scope="module")
def task(tmp_path_factory):
    """Four seeds: the baseline never succeeds in MuJoCo and arp always; in Bullet it is the other way round."""
    reached = {"baseline": reaching(0), ("arp", "pybullet"): reaching(0), ("baseline", "pybullet"): reaching(4)}
    given = {"simulators": ("mujoco", "dm_control", "pybullet"), "engines": ENGINES, "seeds": 4}
    results = build_results(tmp_path_factory.mktemp("it"), reached={**reached, "arp": reaching(4)}, **given)
    (task,) = ranking_of(results).tasks
    return task


def test_rewards_come_by_success_in_each_place(task):
    """The baseline among them, over the seeds that all have."""
    assert task.rewards == ("baseline", "arp")
    assert [(place.simulator, place.engine) for place in task.places] == list(ENGINES.items())[:3]
    assert [place.success.means.tolist() for place in task.places] == [[0, 1], [0, 1], [1, 0]]
    assert {place.success.seeds for place in task.places} == {4}


def test_rewards_come_by_eta_too(task):
    """As published, and its behaviour part; the best first, for eta_N the smallest. Their order is that of success."""
    etas = task.places[0].etas
    assert set(etas) == {"eta_P", "eta_P behaviour", "eta_N", "eta_N behaviour"}
    assert etas["eta_P"].values["baseline"] == 1.0
    assert list(etas["eta_P"].values) == ["arp", "baseline"]
    assert list(etas["eta_N"].values.values()) == sorted(etas["eta_N"].values.values())
    assert [place.etas["eta_P"].tau for place in task.places] == [1.0, 1.0, -1.0]


def test_places_are_compared_that_differ_in_one_alone(task):
    """Here in the simulator."""
    assert [(pair.kind, pair.names) for pair in task.pairs] == [
        ("simulator", ("mujoco", "dm_control")),
        ("simulator", ("mujoco", "pybullet")),
        ("simulator", ("dm_control", "pybullet")),
    ]
    assert [pair.agreement.value for pair in task.pairs] == [1.0, -1.0, -1.0]


def test_simulators_of_one_engine_are_one_vote(task):
    """MuJoCo's agreement with itself counts nothing."""
    assert task.votes("simulator") == ("MuJoCo", "Bullet")
    assert task.between["simulator"] == Estimate(-1.0, -1.0, -1.0, 4)
    assert task.has_engines


def test_another_reward_would_have_been_chosen(task):
    """Between MuJoCo and Bullet, both ways; not between two simulators of MuJoCo."""
    assert [it.answer for it in task.transplants] == [Answer.NO] * 2 + [Answer.YES] * 4
    forth = task.pairs[1].forth
    assert (forth.chosen, forth.best, forth.cost.value) == ("arp", "baseline", 1.0)
    assert (task.count(Answer.YES), task.count(Answer.NOT_DECIDED)) == (4, 0)


def test_without_recorded_engines_every_simulator_votes(tmp_path):
    """As in folders of older versions, and it is told. What has no engine is not taken for one that does not tell."""
    engines = {"dm_control": "MuJoCo", "kinematic": None}
    given = {"simulators": ("mujoco", *engines), "seeds": 1, "engines": engines, "reached": {"arp": reaching(4)}}
    (task,) = ranking_of(build_results(tmp_path, **given)).tasks
    assert task.votes("simulator") == ("mujoco", "MuJoCo", "no engine")
    assert not task.has_engines


def test_a_reward_that_is_not_in_every_place_is_left_out(tmp_path):
    """Its cell failed in one. Seeds of the null control do not count."""
    given = {"proposed": {"arp": (9, 30), "relative": (9, 20)}, "simulators": ("mujoco", "pybullet"), "seeds": 1}
    results = build_results(tmp_path, a_a=True, **given)
    for manifest in results.manifests:
        if (manifest.cell.simulator.label, manifest.cell.reward.label) == ("pybullet", "arp"):
            fail(results.store, manifest.cell, "it fell")
    broken = [it.cell for it in load_results(tmp_path).failed]
    (task,) = ranking_of(load_without(results.store, *broken)).tasks
    assert (task.rewards, task.left_out) == (("baseline", "relative"), ("arp",))
    assert {place.success.seeds for place in task.places} == {1}


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({}, "has 2 rewards in 1 place"),
        ({"proposed": {}, "simulators": ("mujoco", "pybullet")}, "has 1 reward in 2 places"),
    ],
)
def test_what_cannot_be_compared_says_why(tmp_path, given, told):
    """One place, or one reward."""
    ranking = ranking_of(build_results(tmp_path, seeds=1, **given))
    assert ranking.tasks == ()
    assert told in ranking.note


def test_json_is_plain_data(task):
    """Finite numbers, names, lists."""
    data = json.loads(json.dumps(Ranking((task,)).to_json(), allow_nan=False))
    (told,) = data["tasks"]
    assert told["places"][2]["success"] == {"baseline": 1.0, "arp": 0.0}
    assert told["places"][2]["may_be_best"] == ["baseline"]
    assert told["pairs"][1]["chosen_in_one_used_in_other"]["answer"] == "yes"
    assert (told["pairs"][0]["same_vote"], told["pairs"][1]["same_vote"]) == (True, False)
    assert told["between_simulators"]["value"] == -1.0


def test_there_is_no_order_before_the_plan_is_trained_to_its_end(tmp_path):
    """Nor a choice that another place would answer otherwise; the reason says how much is to come."""
    reached = {"baseline": reaching(0), ("baseline", "pybullet"): reaching(4), ("arp", "pybullet"): reaching(0)}
    given = {"simulators": ("mujoco", "pybullet"), "reached": {**reached, "arp": reaching(4)}, "engines": ENGINES}
    found = ranking_of(build_results(tmp_path, seeds=5, ended={("arp", 4): ("pending", "")}, **given))
    assert found == Ranking((), "2 trainings are missing, and an order may change with them")
