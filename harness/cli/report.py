"""``harness report``: what an experiment's folder says."""

import tempfile
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from harness.cli.environments import show_environments
from harness.cli.flags import report as flags
from harness.cli.flags.shared import AsJson, CurveKind, MetricNames, Names, PluginFiles
from harness.cli.lines import complain, say
from harness.cli.not_measured import complain_of_metrics
from harness.cli.study import holds_recordings, refuse_flags, show_study

if TYPE_CHECKING:
    from harness.eta.curve import Kind
    from harness.record.merge import LeftOut
    from harness.results import Results


def report(
    folders: flags.ExperimentFolders,
    curve: CurveKind = "accumulated",
    as_json: AsJson = False,
    html: flags.HtmlFile = None,
    details: flags.Details = False,
    summary: flags.SummaryFolder = None,
    metric: MetricNames = None,
    plugin: PluginFiles = None,
) -> int:
    """Show the results of an experiment. Trains nothing.

    DIR may also hold records that --summary wrote, or trainings that harness.RecordRewards recorded in any environment.
    """
    from harness.report.committed import is_committed
    from harness.results import load_results

    beside = {"--html": html, "--summary": summary, "--details": details}
    if any(map(is_committed, folders)):
        return _show_committed(folders, as_json, [name for name, value in beside.items() if value])
    if holds_recordings(folders):
        refuse_flags({"--summary": summary, "--plugin": plugin})
        return show_study(folders[0], curve, metric, as_json=as_json, html=html, details=details)
    if len(folders) == 1:
        results = load_results(folders[0], curve, metric, plugin or ())
        _leave(results, folders, as_json, html, details, summary)
        if results.damaged:
            complain(f"damaged cells: {len(results.damaged)}; harness verify '{folders[0]}' says which files")
        return 1 if results.damaged else 0
    with ExitStack() as stack:
        together = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="harness-report-")))
        results, left_out = _read_together(folders, together, curve, metric, plugin)
        _leave(results, folders, as_json, html, details, summary)
    for path, reason in left_out:
        complain(f"left out: {path}: {reason}")
    return 1 if left_out else 0


def _show_committed(folders: Sequence[Path], as_json: bool, beside: Sequence[str]) -> int:
    """Of records nothing can be computed anew; what they say is shown."""
    from harness.cli.terminal import show
    from harness.report.committed import committed_table, committed_text, is_committed, refuse_committed

    for folder in filter(is_committed, folders):
        for flag in beside or ["Reading several folders together"] * (len(folders) > 1):
            refuse_committed(folder, flag)
    if as_json:
        typer.echo(committed_text(folders[0]))
    else:
        show(committed_table(folders[0]))
    return 0


def _read_together(
    folders: Sequence[Path], out: Path, curve: "Kind", metric: Names, plugin: Names
) -> "tuple[Results, list[LeftOut]]":
    """All folders as one, in a folder that is soon gone; and what is damaged."""
    from harness.record.merge import merge
    from harness.registry.given import read_given
    from harness.registry.registry import load_registry
    from harness.results import Results

    merged = merge(folders, out)
    registry = load_registry(given=read_given(plugin))
    return Results(out, registry, curve, metrics=metric, is_temporary=True), merged.left_out


def _leave(
    results: "Results", folders: Sequence[Path], as_json: bool, html: Path | None, details: bool, summary: Path | None
) -> None:
    """Write and print what is asked for; by default the table."""
    command = f"harness report {' '.join(map(str, folders))} --details{results.report_flags}"
    if results.is_in_environment:
        show_environments(results, command, as_json=as_json, html=html, details=details, summary=summary)
        return
    complain_of_metrics(results)
    if html is not None:
        from harness.cli.audits import audits_of
        from harness.files.sums import note_made
        from harness.report.page.html import write_html

        write_html(results, html, audits_of(results))
        if html.absolute().parent == results.folder.absolute():
            note_made(html)  # in place of the page that the run made, as the folder's SHA256SUMS tells
        say(f"Report: {html}", err=True)
    if summary is not None:
        from harness.report.summary.summary import write_summary

        write_summary(results, summary)
        say(f"Summary: {summary}", err=True)
    if as_json:
        from harness.report.document import report_text

        typer.echo(report_text(results))
    elif html is None and summary is None:
        _show(results, details, command)


def _show(results: "Results", details: bool, command: str) -> None:
    """The overview, or all there is; in both what policies are worth in other simulators."""
    from harness.cli.terminal import show
    from harness.report.tables.comparison import comparison_table
    from harness.report.tables.overview import overview_table
    from harness.report.tables.ranking import ranking_table
    from harness.report.tables.transfer import transfer_table
    from harness.transfer.matrix import load_transfers

    transfers = load_transfers(results)
    show(comparison_table(results) if details else overview_table(results, command))
    ranking = ranking_table(results, details)
    if ranking is not None:
        show(ranking)
    if transfers.matrices:
        show(transfer_table(transfers))
