"""``harness report``: what an experiment's folder says."""

from pathlib import Path
from typing import Annotated

import typer

from harness.cli.lines import complain, say
from harness.cli.options import CurveKind


def report(
    folder: Annotated[Path, typer.Argument(help="The experiment's folder.", metavar="DIR")],
    curve: CurveKind = "accumulated",
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON on standard output.")] = False,
    html: Annotated[Path | None, typer.Option(help="Write the report page to this file.", metavar="FILE")] = None,
    summary: Annotated[
        Path | None, typer.Option(help="Write small records and figures into this folder.", metavar="FOLDER")
    ] = None,
) -> int:
    """Show the results in an experiment's folder. Trains nothing and imports no engine."""
    from harness.results import load_results

    results = load_results(folder, curve)
    if html is not None:
        from harness.cli.audits import audits_of
        from harness.files.sums import note_made
        from harness.report.html import write_html

        write_html(results, html, audits_of(results))
        if html.absolute().parent == folder.absolute():
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
        from harness.cli.terminal import show
        from harness.report.comparison_table import comparison_table
        from harness.report.transfer_table import transfer_table
        from harness.transfer.matrix import load_transfers

        transfers = load_transfers(results)
        show(comparison_table(results))
        if transfers.matrices:
            show(transfer_table(transfers))
    if results.damaged:
        complain(f"damaged cells: {len(results.damaged)}; harness verify '{folder}' tells of them")
    return 1 if results.damaged else 0
