"""A search in an environment: judged by the measure that decides there."""

import shutil
from pathlib import Path
from typing import Any

import pytest

from harness.errors import UsageError
from harness.experiment.plan import expand, read_experiment
from harness.record.recording.recorded_training import read_recording
from harness.registry.given import read_given
from harness.registry.registry import load_registry
from harness_plugins.tune.outcomes import VALIDATION_SEED
from harness_plugins.tune.trial import Outcome, Tuned, mean_outcome, score
from harness_plugins.tune.tune import TUNING, tune

pytest.importorskip("optuna")
TOY = Path(__file__).parents[2] / "experiment" / "environments" / "toy.py"
ALGORITHM = "sac-fast:learning_starts=8,batch_size=4,net_arch=4"


def _tune(out: Path, **given: Any) -> Tuned:
    told = {"task": "toy", "algo": ALGORITHM, "trials": 2, "seeds": 1, "steps": 32, "validation_episodes": 3, "jobs": 1}
    return tune(**{**told, "search": {"learning_rate": "1e-4..1e-2:log"}, "plugins": [TOY], "out": out, **given})


@pytest.fixture(scope="module")
def tuned(tmp_path_factory: pytest.TempPathFactory) -> Tuned:
    """Two trials."""
    return _tune(tmp_path_factory.mktemp("tuned") / "out")


def test_every_trial_is_judged_by_what_decides(tuned: Tuned):
    """The success of the toy, under both rewards."""
    (search,) = tuned.searches
    assert search.rewards == ("near", "right")
    assert [trial.status for trial in search.trials] == ["complete", "complete"]
    assert all(trial.outcome is not None and trial.outcome.measure == "success" for trial in search.trials)
    assert all(trial.to_json()["success"] == trial.value for trial in search.trials)


def test_the_best_settings_are_an_experiment(tuned: Tuned):
    """In the same environment."""
    assert tuned.file is not None
    plan = expand(read_experiment(tuned.file, {}), load_registry(given=read_given([TOY])))
    assert {cell.task.label for cell in plan.cells} == {"toy"}
    assert len({cell.algorithm for cell in plan.cells}) == 1


def test_validation_has_episodes_of_its_own(tuned: Tuned):
    """Their seeds are none of an evaluation's."""
    recordings = [read_recording(path) for path in sorted((tuned.folder / "validation").glob("*/evaluation"))]
    assert len(recordings) == 4
    assert {recording.facts.seed for recording in recordings} == {1_000_000}
    assert {int((it["terminated"] | it["truncated"]).sum()) for it in recordings} == {3}
    assert VALIDATION_SEED != 1_000_000_007


def test_less_may_be_better():
    """Then the value is turned round."""
    near, far = (Outcome(value, None, "distance", "lower") for value in (0.1, 0.9))
    assert score(near, 100) > score(far, 100)
    assert mean_outcome([near, far]) == Outcome(0.5, None, "distance", "lower")


def test_without_a_measure_nothing_judges(tmp_path: Path):
    """No reward can: each would choose itself."""
    found = _tune(tmp_path / "out", task="gymnasium:id=Pendulum-v1", reward="own", trials=1)
    (trial,) = found.searches[0].trials
    assert trial.status == "failed"
    assert "no measure says what the agent does" in trial.reason


def test_simulator_does_not_go_with_an_environment(tmp_path: Path):
    """It brings its own."""
    with pytest.raises(UsageError, match="--sim does not go with an environment"):
        _tune(tmp_path / "out", sim="kinematic")


def test_a_search_that_was_begun_goes_on_with_its_defaults(tuned: Tuned, tmp_path: Path):
    """Version 0.2 wrote another discount into its file. The same call does no trial again."""
    out = tmp_path / "old"
    shutil.copytree(tuned.folder, out)
    text = (out / TUNING).read_text()
    assert "gamma = 0.99" in text
    (out / TUNING).write_text(text.replace("gamma = 0.99", "gamma = 0.95"))
    assert [trial.value for trial in _tune(out).searches[0].trials] == [it.value for it in tuned.searches[0].trials]
    assert "gamma = 0.95" in (out / TUNING).read_text()
