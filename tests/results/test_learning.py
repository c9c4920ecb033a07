"""Learning curves: what policies did in evaluations while they were trained."""

from collections.abc import Callable
from pathlib import Path

import pytest

from harness.eta.interval import UNBOUNDED
from harness.experiment.plan import check_experiment, expand
from harness.registry.choice import Choice
from harness.registry.registry import Registry
from harness.results import Results
from harness.results.cell_results import PAID
from harness.results.comparison import Group
from harness.results.learning import Learning, LearningCurve, LearningRun, Moment, learning_points
from tests.report.conftest import build_results

GROUP = Group("fd100", Choice("reach"), Choice("wander"), 100, 4, evaluate_every=30, simulator=Choice("ideal"))

RunOnce = Callable[..., Results]


def _run(seed: int, shares: dict[int, float | None]) -> LearningRun:
    return LearningRun(seed, tuple(Moment(steps, {"success_rate": share}) for steps, share in shares.items()))


def _points(*runs: LearningRun) -> list[tuple[int, float | None]]:
    return [(point.steps, point.value.mean) for point in learning_points(runs, "success_rate", GROUP)]


def test_points_are_means_over_seeds():
    """At each evaluation, the final one included."""
    runs = _run(0, {30: 0.0, 60: 0.5, 100: 1.0}), _run(1, {30: 0.5, 60: 0.5, 100: 0.5})
    assert _points(*runs) == [(30, 0.25), (60, 0.5), (100, 0.75)]


def test_points_have_intervals_over_seeds():
    """Around the mean; none of one seed."""
    runs = [_run(seed, {100: 0.4 + 0.05 * seed}) for seed in range(5)]
    (point,) = learning_points(runs, "success_rate", GROUP)
    assert point.value.low < 0.5 < point.value.high
    (share,) = learning_points(runs, "success_rate", GROUP, is_share=True)
    assert share.value.low < point.value.low  # a share allows for the seed that was not seen
    (alone,) = learning_points(runs[:1], "success_rate", GROUP)
    assert (alone.value.low, alone.value.note) == (None, "one seed: no interval below 3 seeds")


def test_evaluations_that_were_due_together_are_one_point():
    """Seeds that were evaluated a little later than others meet at the mean of their steps."""
    assert _points(_run(0, {30: 0.0, 100: 1.0}), _run(1, {36: 1.0, 100: 1.0})) == [(33, 0.5), (100, 1.0)]


def test_the_end_is_a_point_of_its_own():
    """Also where it comes soon after an evaluation."""
    assert _points(_run(0, {99: 0.0, 100: 1.0})) == [(99, 0.0), (100, 1.0)]


def test_seeds_without_a_value_are_told():
    """A metric need not be defined everywhere."""
    (point,) = learning_points([_run(0, {100: None}), _run(1, {100: 1.0})], "success_rate", GROUP)
    assert point.value.mean == 1.0
    assert "1 of 2 seeds have no value here" in point.value.note


def test_no_value_at_all_is_no_number():
    """None, with the reason."""
    (point,) = learning_points([_run(0, {100: None})], "success_rate", GROUP)
    assert (point.value.mean, point.value.note) == (None, "1 of 1 seeds have no value here")


def test_band_has_the_points_with_an_interval():
    """Where one seed alone has a value there is none."""
    runs = [_run(seed, {30: None if seed else 0.5, 60: None, 100: 0.25 * seed}) for seed in range(5)]
    points = learning_points(runs, "success_rate", GROUP)
    curve = LearningCurve("arp", tuple(runs), {"success_rate": points})
    assert curve.band("success_rate") == [(100, points[2].value.low, points[2].value.high)]


def _learning(registry: Registry, run_once: RunOnce, folder: Path, **given: int) -> Learning | None:
    """Of two seeds of a toy, paid by baseline and arp."""
    keys = {"sim": "ideal", "algo": "narrate", "task": "fd100-reach:horizon=5", "seeds": 2, "steps": 12}
    plan = expand(check_experiment({**keys, "evaluation_episodes": 3, **given}), registry)
    results = run_once(plan, folder)
    return results.learning(results.combinations[0])


def test_learning_is_read_from_the_cells(toys: Registry, run_once: RunOnce, tmp_path: Path):
    """Both rewards at each evaluation, every metric, and the floor of random actions."""
    learning = _learning(toys, run_once, tmp_path / "out", evaluate_every=5)
    for curve in (learning.baseline, learning.proposed):
        points = curve.points["final_distance"]
        assert [(point.steps, point.value.seeds) for point in points] == [(5, 2), (10, 2), (12, 2)]
    assert set(learning.random) == set(learning.baseline.points)


def test_learning_keeps_the_runs(toys: Registry, run_once: RunOnce, tmp_path: Path):
    """JSON has the values of each seed behind the means."""
    data = _learning(toys, run_once, tmp_path / "out", evaluate_every=5).to_json()
    runs = data["runs"]["proposed"]
    assert [run["seed"] for run in runs] == [0, 1]
    last = [run["evaluations"][2]["final_distance"] for run in runs]
    point = data["metrics"]["final_distance"]["proposed"][2]
    assert (point["steps"], point["mean"]) == (12, pytest.approx(sum(last) / 2))


@pytest.mark.parametrize("given", [{}, {"evaluate_every": 12}], ids=["not asked for", "none before the end"])
def test_without_evaluation_before_the_end_the_training_is_the_curve(
    toys: Registry, run_once: RunOnce, tmp_path: Path, given: dict[str, int]
):
    """What its episodes came to, in each twentieth of it."""
    learning = _learning(toys, run_once, tmp_path / "out", **given)
    assert set(learning.random) == {"success_rate", PAID}
    assert [point.steps for point in learning.baseline.points[PAID]] == list(range(1, 13))


def test_bands_stay_within_what_a_metric_can_be():
    """No distance is below 0."""
    runs = [_run(seed, {100: 0.1 * seed}) for seed in range(3)]
    (free,), (bound,) = (learning_points(runs, "success_rate", GROUP, bounds=it) for it in (UNBOUNDED, (0.0, 9.0)))
    assert free.value.low is not None
    assert free.value.low < 0.0
    assert (bound.value.low, bound.value.high) == (0.0, free.value.high)


@pytest.mark.parametrize("learned", [{}, {10: 2}], ids=["of the training", "of evaluations"])
def test_all_trainings_are_in_the_curves(tmp_path: Path, learned: dict[int, int]):
    """Also those whose seed the other reward lacks, as in the answer; here there is no seed that both have."""
    missing = {("arp", 0): ("failed", ""), ("arp", 1): ("failed", ""), ("baseline", 2): ("failed", "")}
    results = build_results(tmp_path, learned=learned, ended=missing)
    found = results.learning(results.combinations[0])
    seeds = [curve.points["success_rate"][-1].value.seeds for curve in (found.baseline, found.proposed)]
    assert seeds == [2, 1]


def test_without_a_training_there_is_no_curve(tmp_path: Path):
    """Nothing stands beside the other one."""
    results = build_results(tmp_path, seeds=1, ended={("arp", 0): ("failed", "")})
    assert results.learning(results.combinations[0]) is None
