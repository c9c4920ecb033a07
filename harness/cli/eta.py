"""``harness eta``: two groups of recorded runs compared, or all trainings of a folder."""

import glob
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from harness.cli.datasets import names_dataset
from harness.cli.flags import inputs, logs
from harness.cli.flags.inputs import require_fit
from harness.cli.flags.shared import REWARDS, AsJson, CurveKind, PluginFiles, flag
from harness.cli.output import complain, say, say_json, show_results
from harness.cli.recordings import holds_recordings, is_experiment, told_of_logs
from harness.cli.records import records_in
from harness.errors import UsageError
from harness.text import command_text

if TYPE_CHECKING:
    from harness.eta.curve import Kind
    from harness.registry.choice import Registry
    from harness.results import Results
    from harness.results.logs.told import Told
    from harness.score.compare import ComparedRuns

    OfSteps = tuple[Sequence[str], Sequence[str]]


TrainingsFolder = Annotated[
    Path | None,
    typer.Argument(
        help="A folder of trainings that harness.RecordRewards recorded, of an experiment, or of other logs.",
        metavar="FOLDER",
        show_default=False,
    ),
]
BaselineRuns = Annotated[list[str] | None, flag("GLOB", "Runs of the baseline, such as 'base/*.csv'.", False)]
ProposedRuns = Annotated[
    list[str] | None, flag("GLOB", "Runs of the proposed reward. ** stands for any folders.", False)
]
WithEvents = Annotated[bool, typer.Option("--with-events", help="Add what the task pays for events to the reward.")]
BaselineReward = Annotated[
    str | None, flag("NAME", "The reward that the baseline's runs were trained with.", "found out", offers=REWARDS)
]
ProposedReward = Annotated[
    str | None, flag("NAME", "The reward that the proposed runs were trained with.", "found out", offers=REWARDS)
]
PlotFile = Annotated[Path | None, flag("FILE", "Draw the curves into this .html file.")]


MOST_NAMED = 5


def eta(
    context: typer.Context,
    folder: TrainingsFolder = None,
    baseline: BaselineRuns = None,
    proposed: ProposedRuns = None,
    curve: CurveKind = "accumulated",
    with_events: WithEvents = False,
    baseline_reward: BaselineReward = None,
    proposed_reward: ProposedReward = None,
    plugin: PluginFiles = None,
    as_json: AsJson = False,
    plot: PlotFile = None,
    sort: logs.SortBy = None,
    as_format: logs.AsFormat = None,
    measure: logs.DecidedBy = None,
    labels: logs.LabelsFile = None,
    leave_out: logs.LeftOut = None,
    per_step: logs.StepsOfEach = None,
    ends: logs.EndsOf = None,
) -> int:
    """Compare recorded trainings, such as anybody's CSV files.

    A file has a column 'reward' and a row for each environment step, or is a trace of this harness. If the files have
    distances too, each eta is split into ruler and behaviour. Logs of episodes and curves, such as monitor.csv, tell
    success and returns by seed. All runs are cut to the steps of the shortest. Put patterns in quotes. --baseline and
    --proposed may be given several times. In a FOLDER the names of files say which reward taught, and with which seed.
    """
    loose = [*([] if folder is None or not proposed else [str(folder)]), *context.args]
    if loose:
        raise UsageError(f"'{loose[0]}' belongs to no flag: quote the pattern, as in --baseline 'base/*.csv'")
    if plot is not None and plot.suffix.lower() != ".html":
        raise UsageError(f"--plot writes .html, not '{plot}'")
    if folder is not None and names_dataset(folder):
        audit = command_text("harness", "audit", str(folder))
        raise UsageError(f"'{folder}' is a data set, which holds no trainings to compare: {audit} judges its rewards")
    if folder is None and (baseline is None or proposed is None):
        missing = "--baseline" if baseline is None else "--proposed"
        raise UsageError(f"Missing option '{missing}'; or name a folder of trainings. Examples: harness eta --help")
    from harness.registry.given import read_given
    from harness.registry.registry import load_registry

    registry = load_registry(given=read_given(plugin))
    named = _only(baseline) if folder else None
    measures = [measure] if measure else None
    told_of = partial(told_of_logs, as_format, sort, named, measures, labels, leave_out, per_step, ends)
    if folder is not None:
        if records := records_in([folder]):
            records.refuse(folder, "harness eta")
        opened = _open_folder(context, folder, registry, told_of(), curve)
    else:
        opened = _open_groups(context, [baseline or [], proposed or []], registry, as_format or "", told_of, curve)
    if not isinstance(opened, tuple):
        everything = command_text("harness", "report", opened.folder, "--details")
        status = show_results(opened, everything, as_json=as_json, html=plot, details=True)
        if folder is not None and not as_json:
            say(f"This is what {everything} prints", err=True)
        return status
    from harness.eta.laws import counted
    from harness.score.compare import compare_logs
    from harness.score.open_steps import matched_paths, open_steps

    paths = [matched_paths(patterns) for patterns in opened]
    if leave_out:
        account = counted([(it, it, "") for it in dict.fromkeys([*paths[0], *paths[1]])], leave_out)
        paths = [[it for it in of if it in account.whole] for of in paths]
        for line in account.lines:
            complain(line)
    comparison = compare_logs(
        [open_steps(it, registry) for it in paths[0]],
        [open_steps(it, registry) for it in paths[1]],
        registry,
        kind=curve,
        with_events=with_events,
        baseline_reward=baseline_reward,
        proposed_reward=proposed_reward,
    )
    _show(comparison, plot, as_json)
    return 0


def _only(baseline: Sequence[str] | None) -> str | None:
    """The reward that a folder's others are compared with.

    Raises:
        UsageError: Several were given.
    """
    if baseline is not None and len(baseline) > 1:
        raise UsageError(
            f"--baseline {baseline[1]}: one reward of a folder is the baseline, and {baseline[0]} is named"
        )
    return baseline[0] if baseline else None


def _open_groups(
    context: typer.Context,
    patterns: Sequence[Sequence[str]],
    registry: "Registry",
    as_format: str,
    told_of: "Callable[[], Told]",
    curve: "Kind",
) -> "Results | OfSteps":
    """The results of two groups of logs; the patterns themselves if they are of files of steps."""
    from harness.score.open_steps import is_table_of_steps, matched_paths

    groups = [matched_paths(some, folders=True) for some in patterns]
    if as_format or (not is_table_of_steps(groups[0][0]) and _is_no_log_of_steps(groups[0][0], registry)):
        from harness.results.logs.results_of_logs import results_of_groups

        require_fit(context, inputs.LOGS)
        return results_of_groups(groups, registry, told_of(), curve)
    require_fit(context, inputs.GROUPS)
    baseline, proposed = patterns
    return baseline, proposed


def _is_no_log_of_steps(path: Path, registry: "Registry") -> bool:
    """Whether a file, or what lies below a folder, is a log of episodes or of curves."""
    from harness.log.open_log import first_log

    first = first_log(path, registry)
    return first is not None and first.facts.unit != "step"


def _open_folder(
    context: typer.Context, folder: Path, registry: "Registry", told: "Told", curve: "Kind"
) -> "Results | OfSteps":
    """The results of a folder; or the files of steps of the two rewards in it."""
    from harness.results.load import load_results

    if is_experiment(folder):
        require_fit(context, inputs.EXPERIMENT)
    elif not told.format and holds_recordings([folder]):
        require_fit(context, inputs.RECORDINGS)
    elif not told.format and (groups := _files_of_steps(folder, registry, told)):
        require_fit(context, inputs.STEPS)
        (baseline, ours), (proposed, theirs) = groups.items()
        say(f"CSV files: {len(ours)} of `{baseline}`, the baseline, and {len(theirs)} of `{proposed}`", err=True)
        return list(map(glob.escape, map(str, ours))), list(map(glob.escape, map(str, theirs)))
    else:
        require_fit(context, inputs.LOGS)
    return load_results(folder, curve, told=told, registry=registry)


def _files_of_steps(folder: Path, registry: "Registry", told: "Told") -> dict[str, list[Path]]:
    """The CSV files below a folder by the two rewards that their names tell; none if it holds logs of other kinds.

    Raises:
        UsageError: They are of more rewards than two, or of one.
    """
    from harness.results.logs.trainings import sort_files

    if _is_no_log_of_steps(folder, registry):
        return {}
    files = sorted(folder.rglob("*.csv")) if folder.is_dir() else []
    groups = sort_files(folder, files, told.sort, told.baseline) if files else {}
    if groups and len(groups) != 2:
        shown = ", ".join(f"`{name}` {len(of)}" for name, of in list(groups.items())[:MOST_NAMED])
        raise UsageError(
            f"By their names the CSV files in '{folder}' are of {len(groups)} reward{'s' * (len(groups) > 1)}, "
            f"{shown}; two are compared. Name them, --baseline 'base/*.csv' --proposed 'other/*.csv'; or say how names "
            "are made, --sort '{reward}/{seed}'"
        )
    return groups


def _show(comparison: "ComparedRuns", plot: Path | None, as_json: bool) -> None:
    if plot is not None:
        from harness.report.page.eta import write_eta_page

        write_eta_page(comparison, plot)
        say(f"Figure: {plot}", err=True)
    if as_json:
        say_json(comparison.to_json())
    else:
        from harness.report.rows.ratios import eta_facts
        from harness.report.tables.grid import FactsTable, show

        show(FactsTable(eta_facts(comparison)))
