"""What a training takes, by a few steps of one."""

import pytest

from harness.experiment.plan import check_experiment, expand
from harness.experiment.trials.measured_kind import MOST, Measured, Watched, _Enough, measure_kinds
from harness.record.pace import kind_of
from tests.registered import REGISTRY


def watch(seconds_of, first=0, every=1, steps=10**6, told_every=100):
    """What is found of a training whose steps up to each report take so long, and after how many steps it ends."""
    clock = [0.0]
    watched = Watched(first, every, lambda: clock[0])
    done = 0
    for done in range(told_every, steps + 1, told_every):
        clock[0] += seconds_of(done)
        try:
            watched(done)
        except _Enough:
            break
    return watched, done


def test_steps_before_an_algorithm_learns_do_not_count():
    """They take a hundredth of the time of the others."""
    watched, _ = watch(lambda done: 0.001 if done <= 5_000 else 0.1, first=5_000)
    assert watched.speed[1] == pytest.approx(0.1 / 100)


def test_an_update_counts_for_its_whole_round():
    """Of 2,000 steps in 0.2 s, and a second of learning after each round: 0.6 ms a step, as over a long training."""

    def seconds(done):
        return 0.01 + (1.0 if done > 2_000 and (done - 100) % 2_000 == 0 else 0.0)

    watched, done = watch(seconds, every=2_000)
    assert watched.speed == (4_000, pytest.approx(0.6e-3))
    assert done == 6_100


def test_a_slow_training_is_ended():
    """Before its first update; what is known is the speed until then."""
    watched, done = watch(lambda done: 1.0, every=10**5)
    assert done == 100 * (MOST + 1)
    assert watched.speed[1] == pytest.approx(0.01)


@pytest.mark.parametrize("reports", [1, 2, 3])
def test_a_short_training_is_measured_whole(reports):
    """It ends by itself."""
    watched, _ = watch(lambda done: 0.5, first=10**6, steps=100 * reports)
    assert watched.speed[1] == pytest.approx(0.005)


def test_evaluations_on_the_way_are_counted(make_cell):
    """Two at the end, one at each multiple before it."""
    measured = Measured(steps=100, per_step=0.01, setup=1.0, evaluation=3.0, horizon=0)
    assert measured.of_cell(make_cell(steps=1000)) == (10.0, 6.0)
    assert measured.of_cell(make_cell(steps=1000, evaluate_every=400)) == (10.0, 12.0)
    assert measured.of_cell(make_cell(steps=1000, evaluate_every=500)) == (10.0, 9.0)


def cells(**asked):
    """One of each kind."""
    plan = expand(check_experiment({"steps": 3_000, "seeds": 1, **asked}), REGISTRY)
    return [*{kind_of(cell): cell for cell in plan.cells}.values()]


def test_an_environment_tells_its_horizon_too(tmp_path, monkeypatch):
    """Everything is measured, and nothing stays."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    [cell] = cells(task="gymnasium:id=Pendulum-v1", algo="random")
    [found] = measure_kinds([cell], (), at_once=1).values()
    assert isinstance(found, Measured)
    assert found.horizon == 200
    assert found.steps > 0
    assert min(found.per_step, found.setup, found.evaluation) > 0.0
    assert [*tmp_path.iterdir()] == []


def test_what_fails_has_its_reason(monkeypatch, tmp_path):
    """A process that does not survive is no number."""
    monkeypatch.setattr("harness.experiment.trials.measured_kind.LIMITS", _no_time())
    [cell] = cells(sim="kinematic", algo="random", reward="arp")
    [found] = measure_kinds([cell], (), at_once=1).values()
    assert "took longer" in found


def _no_time():
    from harness.executor import Limits

    return Limits(cell_time=0.01)
