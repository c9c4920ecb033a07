"""Results on standard output and in files, as ``harness run``, ``report`` and ``eta`` show them."""

from pathlib import Path
from typing import TYPE_CHECKING

from harness.cli.output import complain, say
from harness.cli.records import load_records
from harness.errors import UsageError

if TYPE_CHECKING:
    from harness.results import Results


def show_results(
    results: "Results",
    command: str,
    *,
    as_json: bool = False,
    html: Path | None = None,
    details: bool = False,
    summary: Path | None = None,
) -> int:
    """Write and print what is asked for; by default the overview.

    Args:
        results: What to show.
        command: The command that shows everything behind the overview.
        as_json: Whether to print JSON.
        html: Where to write the page.
        details: Whether to print everything that the overview rests on.
        summary: The folder for committed records.

    Returns:
        The exit status: 1 if something is damaged.

    Raises:
        UsageError: Something cannot be written.
    """
    for name, reason in results.not_measured.items():  # its values are missing, and nothing else
        complain(f"metric {name}: n/a ({reason})")
    if html is not None:
        write_page_of(results, html)
        say(f"Report: {html}", err=True)
    if summary is not None:
        load_records().write(results, summary)
        say(f"Summary: {summary}", err=True)
    if as_json:
        from harness.report.document import report_text

        say(report_text(results))
    elif details or (html is None and summary is None):
        _print_tables(results, details, command)
    for line in results.damaged_recordings:
        complain(f"damaged: {line}")
    return 1 if results.damaged_recordings else 0


def write_page_of(results: "Results", html: Path) -> None:
    """Write the page.

    Raises:
        UsageError: The extra ``report`` is missing, or the page cannot be written.
    """
    from harness.cli.audits import audits_of
    from harness.files.sums import note_made
    from harness.report.page.html import write_html

    write_html(results, html, audits_of(results))
    if results.is_experiment and html.absolute().parent == results.folder.absolute():
        note_made(html)  # as the folder's SHA256SUMS tells


def _print_tables(results: "Results", details: bool, command: str) -> None:
    """The overview, or all there is; in both what commands of plugins have to say."""
    from harness.cli.terminal import show
    from harness.report.tables.comparison import comparison_table
    from harness.report.tables.overview import overview_table
    from harness.report.tables.ranking import ranking_table
    from harness.section import shown_sections

    sections = shown_sections(results)
    show(comparison_table(results) if details else overview_table(results, command))
    ranking = ranking_table(results, details)
    if ranking is not None:
        show(ranking)
    for section in sections.values():
        show(section.table())


def make_table_and_page(results: "Results", err: bool = False) -> None:
    """Write ``results.parquet`` and ``report.html``, and say where they are.

    Args:
        results: The experiment.
        err: Say it on standard error: standard output is for something else.

    Raises:
        StorageError: The folder cannot be written.
    """
    from harness.record.out_folder import storage_errors
    from harness.record.store import REPORT

    with storage_errors(results.folder):
        results.write_table()
    say(f"Results: {results.folder}", err)
    try:
        with storage_errors(results.folder):
            _draw_frames(results)
            write_page_of(results, results.folder / REPORT)
        say(f"Report:  {results.folder / REPORT}", err)
    except UsageError as error:  # the extra is missing: the results are there all the same
        say(f"No {REPORT}: {error}", err)


def _draw_frames(results: "Results") -> None:
    """Have environments draw episodes of the policies that are compared, for the page."""
    if results.in_environment:
        from harness.experiment.environments.frames import draw_frames
        from harness.experiment.workers.workers import core_count

        draw_frames(results, core_count())
