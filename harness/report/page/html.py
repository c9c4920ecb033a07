"""The report as one HTML file that opens anywhere, offline."""

import base64
import gzip
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from harness.record.cell import Manifest
from harness.report.document import CellFact, repeat_of, report_text
from harness.report.facts import Report, paragraphs
from harness.report.figures.accumulated import points_of_a_run
from harness.report.page.answer import Card, Matrix, comparisons_csv, groups_of, matrix_of, pool_cards
from harness.report.page.comparison import Panel, Section, alone_panels, comparison_section
from harness.report.page.page import render_page, write_page
from harness.report.replay.section import Replay, links_of, replay_of
from harness.report.rows import Fact
from harness.report.rows.returns import Audits
from harness.report.section import Shown
from harness.results.comparison import still_to_come
from harness.results.replay import shows_of
from harness.results.results import told_manifests


class Download(NamedTuple):
    """A file inside a page."""

    name: str
    kind: str
    """Its media type."""
    content: str
    """The content, compressed by gzip, as base64."""


def pack(name: str, kind: str, text: str) -> Download:
    """A file inside a page. The same text gives the same bytes, because no time of day is in them."""
    return Download(name, kind, base64.b64encode(gzip.compress(text.encode(), mtime=0)).decode())


TEMPLATE = Path(__file__).parent / "report.html.j2"
PROMISE = "at most 6 % of such reports say falsely that one helps or hurts"


@dataclass(frozen=True, eq=False)
class Page:
    """What the template shows; what is not known is empty, and left out."""

    question: str
    comparisons: Sequence[Section]
    is_open: bool
    """Whether the first comparison is shown in full: one of another reward. All others are lines that open."""
    subject: str
    cells: Fact
    counted: str
    """What is counted in `cells`, as a heading."""
    setting: str = ""
    before: Sequence[Fact] = ()
    """What stands before the answers."""
    chosen: Sequence[Fact] = ()
    pools: Sequence[Card] = ()
    groups: Sequence[Mapping[str, Any]] = ()
    alone: Sequence[tuple[Fact, Sequence[Panel] | None]] = ()
    """Each reward that nothing is compared with, how it taught; last how to read them."""
    after: Sequence[Fact] = ()
    """What stands below the answers."""
    numbers_mean: str = ""
    decides: str = ""
    """What the tests hold for."""
    is_curve_open: bool = False
    matrix: Matrix | None = None
    ranking: Sequence[Fact] = ()
    returns: Sequence[Fact] = ()
    added: Sequence[Shown] = ()
    replay: Replay | None = None
    manifests: Sequence[Manifest] = ()
    facts: Sequence[CellFact] = ()
    again: str = ""
    experiment: str = ""
    downloads: Sequence[Download] = ()


def render(page: Page, noun: str) -> str:
    """The page as HTML.

    Raises:
        UsageError: The extra ``report`` is missing; `noun` says what for.
    """
    return render_page(TEMPLATE, noun, **vars(page))


def write_html(report: Report, path: Path, audits: Audits = MappingProxyType({})) -> None:
    """Write the report to `path`, in one go: a reader finds the old file or the new one, whole.

    Args:
        report: What it says.
        path: The page.
        audits: What the rewards pay for, if an audit was made.

    Raises:
        UsageError: The extra ``report`` is missing, or `path` cannot be written.
    """
    write_page(_render(report, audits), path, "The report")


def _render(report: Report, audits: Audits) -> str:
    results, combinations = report.results, report.results.combinations
    points = points_of_a_run(sum(2 * len(comparison.seeds) for comparison in combinations))
    matrix = matrix_of(combinations)
    shows = shows_of(results)
    links = links_of(shows, combinations)
    sections = [
        comparison_section(report, place, entry.place, points, audits, found)
        for place, (entry, found) in enumerate(zip(matrix.entries, links, strict=True), 1)
    ]
    is_open = sum(not it.is_control for it in combinations) < 2
    is_promised = any(it.answer.ruling for it in combinations) and not still_to_come(combinations)
    ended = f"{report.cells.title}. The last part of the page has the reasons."
    page = Page(
        question=report.question,
        setting=" · ".join(filter(None, (report.setting, PROMISE * is_promised))),
        before=[
            *report.said,
            *paragraphs(ended * bool(results.failed or results.damaged), kind="warning"),
            *report.warnings,
        ],
        chosen=report.chosen,
        pools=pool_cards(combinations),
        comparisons=sections,
        is_open=is_open,
        groups=groups_of([section.card for section in sections], combinations, is_open * 1),
        alone=list(zip_longest(report.alone, map(alone_panels, results.alone))),
        after=[*report.never, *report.advice, *report.beside],
        subject=results.subject,
        numbers_mean=report.numbers_mean,
        decides=report.decides,
        matrix=matrix,
        ranking=report.ranking,
        returns=report.returns,
        added=tuple(report.sections.values()),
        replay=replay_of(shows),
        cells=report.cells,
        counted="Cells" if results.is_experiment else "Recordings",
        manifests=told_manifests(results),
        **repeat_of(results),
        downloads=[
            pack("comparisons.csv", "text/csv", comparisons_csv(combinations)),
            pack("report.json", "application/json", report_text(report)),
        ],
    )
    return render(page, "The HTML report")
