"""Reads the results in a folder, whatever was trained: arms, policies in environments, or recordings that lie loose."""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from harness.errors import UsageError
from harness.eta.curve import Kind
from harness.record.plan_file import PLAN
from harness.record.store import Store
from harness.registry.choice import Registry
from harness.registry.given import read_given
from harness.registry.registry import load_registry
from harness.results.logs.results_of_logs import results_of_logs
from harness.results.logs.told import FOUND_OUT, Told
from harness.results.recordings.recordings import Recordings, has_recordings, plan_of, read_loose
from harness.results.results import Results
from harness.results.traces import Traces


def load_results(
    folder: str | Path,
    kind: Kind = "accumulated",
    metrics: Iterable[str] | str | None = None,
    plugins: Iterable[str | Path | type] = (),
    *,
    pairs: bool = False,
    measures: Iterable[str | Path] = (),
    told: Told | None = None,
    registry: Registry | None = None,
    is_temporary: bool = False,
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
        registry: The plugins, where they are loaded already.
        is_temporary: Whether the folder is soon gone, so that no command may name it.

    Raises:
        UsageError: The folder holds no results, or a named metric is not registered.
        PluginError: A named metric is broken.
        SchemaError: A newer version wrote a file in it, or its plan is damaged and the cells do not tell either.
    """
    folder, told = Path(folder), told or FOUND_OUT
    registry = registry or load_registry(given=read_given(plugins, measures))
    loose = None
    if Store.is_experiment(folder):
        plan = Store.open(folder).read_plan()
    elif told.format or not has_recordings(folder):
        if not told.sort and next(folder.glob(f"*/{PLAN}"), None):
            Store.open(folder)  # names the experiments in it
        return results_of_logs(folder, registry, told, kind, metrics, pairs=pairs)
    else:
        loose = read_loose(folder, told)
        plan, told = plan_of(loose), replace(told, leave_out=())
    kinds = {cell.is_in_environment for cell in plan.cells}
    if len(kinds) > 1:
        raise UsageError(f"'{folder}' mixes cells of an arm with cells in environments: report them apart")
    return (Recordings if kinds == {True} else Traces)(
        folder, registry, plan, kind, metrics=metrics, is_temporary=is_temporary, pairs=pairs, told=told, loose=loose
    )
