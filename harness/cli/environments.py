"""An experiment whose task is an environment, as ``harness run``, ``report`` and ``merge`` show it."""

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from harness.cli.lines import say

if TYPE_CHECKING:
    from harness.results import Results


def show_environments(
    results: "Results",
    command: str,
    *,
    as_json: bool,
    html: Path | None,
    details: bool,
    summary: Path | None,
) -> None:
    """Write and print what is asked for; by default the overview.

    Args:
        results: Of the experiment.
        command: Shows all that the overview rests on.
        as_json: Whether to print JSON.
        html: Where to write the page; with several algorithms one beside the other.
        details: Whether to print all that the overview rests on.
        summary: The folder for committed records.

    Raises:
        UsageError: Something cannot be written.
    """
    from harness.cli.terminal import show
    from harness.report.environments.document import environments_text
    from harness.report.environments.summary import write_environments_summary
    from harness.report.environments.table import environments_table

    if html is not None:
        write_pages(results, html, err=True)
    if summary is not None:
        write_environments_summary(results, summary)
        say(f"Summary: {summary}", err=True)
    if as_json:
        typer.echo(environments_text(results))
    elif html is None and summary is None:
        show(environments_table(results, command, details))


def write_pages(results: "Results", path: Path, err: bool = False) -> None:
    """Write a page for each study that compares something, and say where it is.

    Raises:
        UsageError: The extra ``report`` is missing, or a page cannot be written.
    """
    from harness.files.sums import note_made
    from harness.report.trainings.page import write_study_page
    from harness.results.recordings.places import page_names

    compared = [told.study for told in results.studies if told.study is not None]
    if not compared:
        reasons = "; ".join(dict.fromkeys(told.reason for told in results.studies)) or "no cell is done"
        say(f"No {path.name}: {reasons}", err)
    for study, name in zip(compared, page_names(results.studies, path.name), strict=True):
        page = path.with_name(name)
        write_study_page(study, page, results)
        if page.absolute().parent == results.folder.absolute():
            note_made(page)
        say(f"Report:  {page}", err)
