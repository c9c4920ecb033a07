"""MLflow, in a local file."""

import pytest

from harness.tracker import TrackedCell
from harness_plugins.trackers.mlflow import GROUP, MLflow

pytest.importorskip("mlflow", reason="needs the extra mlflow")

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")  # the library's own, of SQLAlchemy
URI = "sqlite:///mine.db"


def _client():
    from mlflow import MlflowClient

    return MlflowClient(tracking_uri=URI)


def _runs():
    client = _client()
    return client.search_runs([client.get_experiment_by_name("arms").experiment_id])


def test_a_run_holds_cell_and_numbers(tracked: TrackedCell):
    """Its name, group, parameters and curve, and how it ended."""
    track = MLflow(uri=URI, experiment="arms").begin(tracked)
    track.log(100, {"Training/Success Rate": 0.5})
    track.log(200, {"Training/Success Rate": 0.75})
    track.end("failed", "the arm fell off")
    [run] = _runs()
    assert (run.info.run_name, run.info.status) == (tracked.title, "FAILED")
    assert run.data.tags[GROUP] == tracked.group
    assert run.data.params["task.horizon"] == "5"
    curve = _client().get_metric_history(run.info.run_id, "Training/Success Rate")
    assert [(point.step, point.value) for point in curve] == [(100, 0.5), (200, 0.75)]


def test_a_cell_that_goes_on_is_one_run(tracked: TrackedCell):
    """Its curve has both parts."""
    tracker = MLflow(uri=URI, experiment="arms")
    tracker.begin(tracked).log(100, {"loss": 1.0})
    track = tracker.begin(tracked)
    track.log(200, {"loss": 0.5})
    track.end("done", "")
    [run] = _runs()
    curve = _client().get_metric_history(run.info.run_id, "loss")
    assert ([point.step for point in curve], run.info.status) == ([100, 200], "FINISHED")


def test_a_store_that_cannot_be_used_says_why(tmp_path, monkeypatch):
    """Before anything starts, and nothing is written for it."""
    monkeypatch.chdir(tmp_path)
    assert "give uri=sqlite:///mlflow.db" in MLflow(uri=f"{tmp_path}/mlruns").why_not()
    assert MLflow(uri=URI).why_not() == ""
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert "sqlalchemy, alembic: pip install 'fd100-harness[mlflow]'" in MLflow(uri=URI).why_not()
    assert list(tmp_path.iterdir()) == []
