"""Learning curves: what policies did in evaluations while they were trained."""

import pytest

from harness.eta import Quantity
from harness.registry import Choice
from harness.results import Group
from harness.results.recordings.episodes import Did, Part
from harness.results.trainings import Trainings
from tests.report.conftest import build_results

GROUP = Group("fd100", Choice("reach"), Choice("wander"), 100, 4, evaluate_every=30, simulator=Choice("ideal"))


class Evaluated(Did):
    """A training of 100 steps that was evaluated: the share of its episodes that succeeded, by steps."""

    seed, cut, _manners, _floor, episodes = 0, 100, {}, {}, None

    def __init__(self, shares):
        self.shares = shares

    @property
    def _evaluated(self):
        return {steps: Part(4, {}, {"success_rate": share}, {}) for steps, share in self.shares.items()}


def _curve(*runs, episodes=None, **given):
    """Of these shares by steps, one run for each seed."""
    measure, none = Quantity("success_rate", "", "higher", "", episodes, **given), ()
    kept = Trainings(GROUP, "a", {}, ["success_rate"], lambda *_: measure, "paid", none, none, "", 1, {}, False)
    (curve,) = kept.learned([("a", [Evaluated(shares) for shares in runs])])
    return curve


def _points(*runs, **given):
    return _curve(*runs, **given).points["success_rate"]


@pytest.mark.parametrize(
    ("runs", "points"),
    [
        (({30: 0.0, 60: 0.5, 100: 1.0}, {30: 0.5, 60: 0.5, 100: 0.5}), [(30, 0.25), (60, 0.5), (100, 0.75)]),
        (({30: 0.0, 100: 1.0}, {36: 1.0, 100: 1.0}), [(33, 0.5), (100, 1.0)]),
        (({66: 0.5, 99: 0.0, 100: 1.0},), [(66, 0.5), (99, 0.0), (100, 1.0)]),
        (({66: 0.5, 97: 0.0, 104: 1.0},), [(66, 0.5), (97, 0.0), (104, 1.0)]),
    ],
    ids=["means over seeds", "due together: one point", "the end is its own", "the end was overshot"],
)
def test_points_are_where_evaluations_were_due(runs, points):
    """Seeds that were evaluated a little later than others meet at the mean of their steps."""
    assert [(point.steps, point.mean.value) for point in _points(*runs)] == points


def test_points_have_intervals_over_seeds():
    """Around the mean; none of one seed."""
    runs = [{60: 0.0, 100: 0.4 + 0.05 * seed} for seed in range(5)]
    (*_, point), (*_, share), (*_, alone) = _points(*runs), _points(*runs, episodes=4), _points(runs[0])
    assert point.mean.low < 0.5 < point.mean.high
    assert share.mean.low < point.mean.low  # a share allows for the seed that was not seen
    assert (alone.mean.low, alone.mean.note) == (None, "one seed: no interval below 3 seeds")


@pytest.mark.parametrize(("other", "mean", "told"), [((1.0,), 1.0, "1 of 2 seeds"), ((), None, "1 of 1 seeds")])
def test_seeds_without_a_value_are_told(other, mean, told):
    """A metric need not be defined everywhere; where it is nowhere, there is no number."""
    (*_, point) = _points({60: 0.0, 100: None}, *({60: 0.0, 100: share} for share in other))
    assert point.mean.value == mean
    assert f"{told} have no value here" in point.mean.note


def test_band_has_the_points_with_an_interval():
    """Where one seed alone has a value there is none."""
    curve = _curve(*({30: None if seed else 0.5, 60: None, 100: 0.25 * seed} for seed in range(5)))
    points = curve.points["success_rate"]
    assert curve.band("success_rate") == [(100, points[2].mean.low, points[2].mean.high)]


def test_bands_stay_within_what_a_metric_can_be():
    """No distance is below 0."""
    runs = [{60: 0.0, 100: 0.1 * seed} for seed in range(3)]
    (*_, free), (*_, bound) = _points(*runs), _points(*runs, bounds=(0.0, float("inf")))
    assert free.mean.low < 0.0
    assert (bound.mean.low, bound.mean.high) == (0.0, free.mean.high)


@pytest.fixture(name="learning")
def _learning(ran_toys):
    """Of two seeds of a toy, paid by baseline and arp."""

    def learn(**given):
        results = ran_toys(reward="arp", **given)
        return results.learning(results.combinations[0])

    return learn


def test_learning_is_read_from_the_cells(learning):
    """Both rewards at each evaluation, every metric, and the floor of random actions; JSON has each seed's values."""
    found = learning(evaluate_every=5)
    for curve in found.curves:
        points = curve.points["final_distance"]
        assert [(point.steps, point.mean.seeds) for point in points] == [(5, 2), (10, 2), (12, 2)]
    assert set(found.random) == set(found.curves[0].points)
    data = found.to_json()
    runs = data["runs"]["proposed"]
    assert [run["seed"] for run in runs] == [0, 1]
    last = [run["evaluations"][2]["final_distance"] for run in runs]
    point = data["metrics"]["final_distance"]["proposed"][2]
    assert (point["steps"], point["value"]) == (12, pytest.approx(sum(last) / 2))


@pytest.mark.parametrize("every", [0, 12], ids=["not asked for", "none before the end"])
def test_without_evaluation_before_the_end_the_training_is_the_curve(learning, every):
    """What its episodes came to, in each twentieth of it."""
    found = learning(evaluate_every=every)
    assert set(found.random) == {"success_rate", "return, as paid"}
    assert [point.steps for point in found.curves[0].points["return, as paid"]] == list(range(1, 13))


@pytest.mark.parametrize("learned", [{}, {10: 2}], ids=["of the training", "of evaluations"])
def test_all_trainings_are_in_the_curves(tmp_path, learned):
    """Also those whose seed the other reward lacks, as in the answer; here there is no seed that both have."""
    missing = dict.fromkeys([("arp", 0), ("arp", 1), ("baseline", 2)], ("failed", ""))
    results = build_results(tmp_path, learned=learned, ended=missing)
    found = results.learning(results.combinations[0])
    seeds = [curve.points["success_rate"][-1].mean.seeds for curve in found.curves]
    assert seeds == [2, 1]


def test_without_a_training_there_is_no_curve(tmp_path):
    """Nothing stands beside the other one."""
    results = build_results(tmp_path, seeds=1, ended={("arp", 0): ("failed", "")})
    assert results.learning(results.combinations[0]) is None
