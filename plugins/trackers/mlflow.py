"""The tracker `mlflow`."""

import importlib.util
import logging
import os
import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated
from urllib.parse import urlsplit

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.tracker import Outcome, TrackedCell

if TYPE_CHECKING:
    from mlflow import MlflowClient

ID, GROUP, OUTCOME, REASON = "harness.id", "harness.group", "harness.outcome", "harness.reason"
DATABASES = ("sqlite", "mysql", "postgresql", "mssql")
STATUS = {"done": "FINISHED", "failed": "FAILED", "interrupted": "KILLED"}


@dataclass(frozen=True)
class MLflow:
    """A run for each cell; a tag says its combination.

    The library's own environment variables, such as MLFLOW_TRACKING_URI, have effect.
    """

    uri: Annotated[
        str,
        Field(description="address of the server, or sqlite:///FILE; empty: MLFLOW_TRACKING_URI, or mlflow.db here"),
    ] = ""
    experiment: Annotated[str, Field(min_length=1, description="experiment that the runs belong to")] = "fd100-harness"

    def why_not(self) -> str:
        import mlflow

        uri = self.uri or mlflow.get_tracking_uri()
        scheme = urlsplit(uri).scheme
        if scheme in ("", "file") and os.environ.get("MLFLOW_ALLOW_FILE_STORE") != "true":
            return f"MLflow keeps nothing in plain folders any more, as '{uri}' asks: give uri=sqlite:///mlflow.db"
        missing = [name for name in ("sqlalchemy", "alembic") if importlib.util.find_spec(name) is None]
        if scheme.startswith(DATABASES) and missing:
            return f"'{uri}' needs {', '.join(missing)}: pip install 'fd100-harness[mlflow]'"
        return ""

    def begin(self, cell: TrackedCell) -> "Run":
        client = self._client()
        found = client.get_experiment_by_name(self.experiment)
        experiment = found.experiment_id if found else client.create_experiment(self.experiment)
        known = client.search_runs([experiment], f"tags.`{ID}` = '{cell.id}'")
        if known:
            run = known[0].info.run_id
            client.update_run(run, status="RUNNING")
            return Run(client, run)
        tags = {ID: cell.id, GROUP: cell.group}
        run = client.create_run(experiment, run_name=cell.title, tags=tags).info.run_id
        client.log_batch(run, params=_params(cell.config))
        return Run(client, run)

    def _client(self) -> "MlflowClient":
        os.environ.setdefault("MLFLOW_DISABLE_TELEMETRY", "true")  # nothing is reported to its makers
        from mlflow import MlflowClient

        logging.getLogger("mlflow").setLevel(logging.ERROR)  # else it reports a new file, amid the progress of cells
        return MlflowClient(tracking_uri=self.uri or None)


class Run:
    """MLflow's run of one cell."""

    def __init__(self, client: "MlflowClient", run: str) -> None:
        self._client, self._run = client, run

    def log(self, steps: int, scalars: Mapping[str, float]) -> None:
        from mlflow.entities import Metric

        now = int(1000 * time.time())
        self._client.log_batch(self._run, metrics=[Metric(name, value, now, steps) for name, value in scalars.items()])

    def end(self, outcome: Outcome, reason: str) -> None:
        self._client.set_tag(self._run, OUTCOME, outcome)
        if reason:
            self._client.set_tag(self._run, REASON, reason)
        self._client.set_terminated(self._run, STATUS[outcome])


def _params(config: Mapping[str, object]) -> list[object]:
    from mlflow.entities import Param

    return [Param(name, str(value)) for name, value in config.items()]
