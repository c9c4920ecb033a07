"""The page that ``harness watch`` serves: the answers of an experiment so far, and its replay, while it goes on."""

from pathlib import Path

from harness.report.page.page import render_page
from harness.report.replay.section import replay_of
from harness.report.rows.comparison import question
from harness.results import Results
from harness.results.overview import line_names, overview_of, overview_row
from harness.results.replay import shows_of

TEMPLATE = Path(__file__).parent / "watch.html.j2"
STATE = "/state"
"""Where the page asks whether cells have ended since."""


def _answers(results: Results) -> tuple[tuple[str, ...], list[tuple[str, ...]]] | None:
    """The comparisons so far: headings, and a row for each; None before there is one."""
    combinations = [it for it in results.combinations if it.seeds]
    if not combinations:
        return None
    overview, names = overview_of(combinations), line_names(combinations)
    rows = [overview_row(name, it, True, overview) for name, it in zip(names, combinations, strict=True)]
    return overview.headings, rows


def watch_page(results: Results, state: str) -> str:
    """The page, as HTML.

    Args:
        results: The experiment as it stands.
        state: What `STATE` answers as long as nothing new is there to be shown.

    Raises:
        UsageError: A library of the extra ``report`` is missing.
        SchemaError: A file is damaged or written by a newer version.
    """
    return render_page(
        TEMPLATE,
        "The replay",
        title=question(results),
        status=f"{len(results.done)} of {len(results.manifests)} cells are done.",
        state=state,
        answers=_answers(results),
        replay=replay_of(shows_of(results)),
    )
