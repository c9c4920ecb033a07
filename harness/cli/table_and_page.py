"""What is made from an experiment's cells, in its folder."""

from typing import TYPE_CHECKING

from harness.cli.output import say
from harness.errors import UsageError

if TYPE_CHECKING:
    from harness.results import Results


def make_table_and_page(results: "Results", err: bool = False) -> None:
    """Write ``results.parquet`` and ``report.html``, and say where they are.

    Args:
        results: The experiment.
        err: Say it on standard error: standard output is for something else.

    Raises:
        StorageError: The folder cannot be written.
    """
    from harness.cli.results_shown import write_page_of
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
