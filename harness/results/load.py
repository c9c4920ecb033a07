"""Reads the results in a folder, whatever was trained: arms, policies in environments, or recordings that lie loose."""

from collections.abc import Iterable
from pathlib import Path

from harness.eta.curve import Kind
from harness.record.store import Store
from harness.registry.given import read_given
from harness.registry.registry import Registry, load_registry
from harness.results.logs.results_of_logs import results_of_logs
from harness.results.logs.told import FOUND_OUT, Told
from harness.results.recordings.read_runs import has_recordings, read_loose
from harness.results.results import Results


def load_results(
    folder: str | Path,
    kind: Kind = "accumulated",
    metrics: Iterable[str] | str | None = None,
    plugins: Iterable[str | Path | type] = (),
    *,
    pairs: bool = False,
    measures: Iterable[str | Path] = (),
    told: Told | None = None,
) -> Results:
    """The results in an experiment's folder, or of the recorded trainings or the logs in a folder.

    Args:
        folder: The folder of the experiment, or one in which recorded trainings lie, at any depth; or logs of a format
            that is read, such as ``monitor.csv``.
        kind: Which curves the indices are read from; see `harness.eta.curve.GroupCurve`.
        metrics: Which metrics; every registered one if None, see `harness.results.metrics.load_metrics`. If an
            environment was trained in: which of its measures, beside the one that decides.
        plugins: Files and classes beside the installed plugins; see `harness.registry.given.read_given`.
        pairs: Whether every two rewards are compared, and not each with the baseline alone. All claims are corrected
            together, so more of them have larger p-values.
        measures: Files whose functions measure what an arm does.
        told: What the user says of logs, and which trainings are left out; see `harness.results.logs.told.Told`.

    Raises:
        UsageError: The folder holds no results, or a named metric is not registered.
        PluginError: A named metric is broken.
        SchemaError: A newer version wrote a file in it, or its plan is damaged and the cells do not tell either.
    """
    return read_results(
        Path(folder), load_registry(given=read_given(plugins, measures)), kind, metrics, pairs=pairs, told=told
    )


def read_results(
    folder: Path,
    registry: Registry,
    kind: Kind = "accumulated",
    metrics: Iterable[str] | str | None = None,
    *,
    is_temporary: bool = False,
    pairs: bool = False,
    told: Told | None = None,
) -> Results:
    """The same, with plugins that are loaded already.

    Args:
        folder: See `load_results`.
        registry: The plugins.
        kind: See `load_results`.
        metrics: See `load_results`.
        is_temporary: Whether the folder is soon gone, so that no command may name it.
        pairs: See `load_results`.
        told: What the user says of logs.
    """
    told = told or FOUND_OUT
    if Store.is_experiment(folder):
        return Results(folder, registry, kind, metrics=metrics, is_temporary=is_temporary, pairs=pairs, told=told)
    if told.format or not has_recordings(folder):
        return results_of_logs(folder, registry, told, kind, metrics, pairs=pairs)
    runs = read_loose(folder, told)
    return Results(folder, registry, kind, metrics=metrics, is_temporary=is_temporary, runs=runs, pairs=pairs)
