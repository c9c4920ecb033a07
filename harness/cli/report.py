"""``harness report``: what an experiment's folder says."""

import tempfile
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from harness.cli.datasets import names_dataset
from harness.cli.flags import inputs, logs
from harness.cli.flags.inputs import require_fit
from harness.cli.flags.shared import AsJson, CurveKind, FailOn, MetricNames, Names, PluginFiles, flag
from harness.cli.output import complain, say, show_results
from harness.cli.recordings import holds_recordings, is_experiment, require_one_folder, told_of_logs
from harness.cli.records import Records, records_in
from harness.errors import UsageError
from harness.text import command_text

if TYPE_CHECKING:
    from harness.eta.curve import Kind
    from harness.registry.given import Given
    from harness.results import Results
    from harness.results.logs.told import Told


ExperimentFolders = Annotated[
    list[Path],
    typer.Argument(
        help="The folder of an experiment. Several folders are read as if one run had made them.", metavar="DIR..."
    ),
]
HtmlFile = Annotated[Path | None, flag("FILE", "Write the report page to this file.")]
Details = Annotated[
    bool,
    typer.Option(
        "--details", help="Print every number of every comparison. With many comparisons this fills many screens."
    ),
]
Pairs = Annotated[
    bool,
    typer.Option(
        "--pairs",
        help="Compare every two rewards, not each with the baseline alone. All claims are corrected together. In "
        "environments that is always so.",
    ),
]
SummaryFolder = Annotated[
    Path | None, flag("FOLDER", "Write records into this folder: small tables and figures, made to be kept and shared.")
]
MeasureFiles = Annotated[
    list[str] | None,
    flag(
        "FILE|NAME",
        "A Python file whose functions measure what an arm does; can be repeated. Of logs: what decides, such as "
        "success or length:better=lower. return decides where one and the same reward paid all of them.",
        False,
        name="--measure",
    ),
]


def report(
    context: typer.Context,
    folders: ExperimentFolders,
    curve: CurveKind = "accumulated",
    as_json: AsJson = False,
    html: HtmlFile = None,
    details: Details = False,
    summary: SummaryFolder = None,
    metric: MetricNames = None,
    pairs: Pairs = False,
    measure: MeasureFiles = None,
    plugin: PluginFiles = None,
    baseline: logs.BaselineName = None,
    sort: logs.SortBy = None,
    as_format: logs.AsFormat = None,
    labels: logs.LabelsFile = None,
    leave_out: logs.LeftOut = None,
    per_step: logs.StepsOfEach = None,
    ends: logs.EndsOf = None,
    fail_on: FailOn = None,
) -> int:
    """Show the results of an experiment. Trains nothing.

    DIR may also hold records that --summary wrote, trainings that harness.RecordRewards recorded in any environment, or
    logs of trainings such as monitor.csv, which are sorted by the names of their files: a number is the seed.
    A data set, minari:NAME, lerobot:FOLDER, d4rl:FILE or robomimic:FILE, shows what its own rewards say; harness
    audit adds others.
    """
    from harness.cli.fail_on import named_answers, said_of, status_of

    named = named_answers(fail_on, "behaviour", "ranking")
    if any(map(names_dataset, folders)):
        if len(folders) > 1:
            raise UsageError("One data set is reported at a time: name it alone")
        require_fit(context, inputs.DATASET)
        from harness.cli.commands import KIND
        from harness.registry.registry import load_registry

        # The command that answers for any rewards answers for those of the data set.
        audit: Callable[..., int] = load_registry().get(KIND, "audit").load()
        return audit(context, str(folders[0]), as_json=as_json, html=html, labels=labels, fail_on=fail_on)
    from harness.registry.given import read_given
    from harness.results.load import load_results

    records = records_in(folders)
    if records is not None:
        return _show_records(records, folders, as_json, inputs.unfit(context, inputs.RECORDS))
    of_experiment = any(map(is_experiment, folders))
    given = inputs.EXPERIMENT
    if not of_experiment and (as_format or not holds_recordings(folders)):
        require_one_folder(folders, inputs.LOGS)
        given = inputs.LOGS
    elif holds_recordings(folders):
        given = inputs.RECORDINGS
    require_fit(context, given)
    deciding = None if of_experiment else measure
    files = measure if of_experiment else None
    told = told_of_logs(as_format, sort, baseline, deciding, labels, leave_out, per_step, ends)
    show = partial(show_results, as_json=as_json, html=html, details=details, summary=summary)
    if len(folders) == 1:
        results = load_results(folders[0], curve, metric, plugin or (), pairs=pairs, measures=files or (), told=told)
        if results.in_environment and results.is_experiment:
            require_fit(context, inputs.ENVIRONMENTS)
        status = show(results, _details(results, folders, told))
        if results.damaged:
            verify = command_text("harness", "verify", folders[0])
            complain(f"damaged cells: {len(results.damaged)}; {verify} says which files")
        return status_of(named, said_of(results) if named else (), 1 if results.damaged else status)
    with ExitStack() as stack:
        together = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="harness-report-")))
        results, left_out = _read_together(folders, together, curve, metric, read_given(plugin, files), pairs, told)
        show(results, _details(results, folders, told))
        said = said_of(results) if named else []
    for path, reason in left_out:
        complain(f"left out: {path}: {reason}")
    return status_of(named, said, 1 if left_out else 0)


def _show_records(records: Records, folders: Sequence[Path], as_json: bool, beside: Sequence[str]) -> int:
    """Show what records say. Nothing can be computed anew of them."""
    from harness.report.tables.grid import show

    for folder in filter(records.are_in, folders):
        for name in beside or ["Reading several folders together"] * (len(folders) > 1):
            records.refuse(folder, name)
    if as_json:
        say(records.text(folders[0]))
    else:
        show(records.table(folders[0]))
    return 0


def _read_together(
    folders: Sequence[Path],
    out: Path,
    curve: "Kind",
    metric: Names,
    given: "Sequence[Given]",
    pairs: bool,
    told: "Told",
) -> "tuple[Results, list[tuple[Path, str]]]":
    """All folders as one, in a folder that is soon gone; and what is damaged."""
    from harness.eta.laws import is_left_out
    from harness.record.merge import merge
    from harness.registry.registry import load_registry
    from harness.results.load import load_results

    merged = merge(folders, out, is_temporary=True)
    registry = load_registry(given=given)
    homes = [(path, folder) for path in told.leave_out for folder in folders if is_left_out(path, [folder])]
    there = {path: out / path.absolute().relative_to(folder.absolute()) for path, folder in homes}
    told = replace(told, leave_out=tuple(there.get(path, path) for path in told.leave_out))
    results = load_results(out, curve, metric, pairs=pairs, told=told, registry=registry, is_temporary=True)
    return results, merged.left_out


def _details(results: "Results", folders: Sequence[Path], told: "Told") -> str:
    """The command that shows everything behind the overview, with the flags that say the same of logs again."""
    name, better = told.deciding
    measure = f"{name}{':better=' * bool(better)}{better}"
    given = {
        "--as": told.format, "--sort": told.sort, "--baseline": told.baseline, "--measure": measure,
        "--labels": str(told.labels or ""), "--per-step": told.per_step,
    }  # fmt: skip
    left_out = (("--leave-out", str(path)) for path in told.leave_out)
    ends = (("--ends", f"{name}={low:g},{high:g}") for name, (low, high) in told.ends.items())
    flags = [text for flag, value in (*given.items(), *left_out, *ends) if value for text in (flag, value)]
    return command_text("harness", "report", *folders, "--details", *flags) + results.report_flags
