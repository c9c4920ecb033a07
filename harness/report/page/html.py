"""The report as one HTML file that opens anywhere, offline."""

import base64
import gzip
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from harness.record.cell import Manifest
from harness.report.document import CellFact, repeat_of, report_text
from harness.report.facts import advice_facts, beside_facts, choosing_facts, return_facts, said_facts
from harness.report.figures.accumulated import points_of_a_run
from harness.report.figures.split import EXPLANATION as FOREST
from harness.report.page.answer import Card, Matrix, comparisons_csv, groups_of, matrix_of, pool_cards
from harness.report.page.comparison import Section, alone_section, comparison_section
from harness.report.page.page import render_page, write_page
from harness.report.replay.section import Replay, links_of, replay_of
from harness.report.rows import Fact
from harness.report.rows.comparison import (
    ALONE,
    BETWEEN,
    LEGEND,
    POOLED,
    count_cells,
    grown_text,
    interim_text,
    joined_text,
    question,
    remarks_on_cells,
    setting_of,
    what_decides,
)
from harness.report.rows.ranking import (
    AGREEMENT,
    CHOICE,
    EXPLANATION as RANKING,
    TITLE as RANKING_TITLE,
    TaskRows,
    task_rows,
)
from harness.report.rows.ratios import PATHS, SPLIT, TOTAL, scales_text
from harness.report.rows.returns import (
    EXPLANATION as RETURNS,
    INDICES,
    PAY,
    PAYOFF_TITLE,
    PAYOFFS,
    READING,
    TERMS,
    TERMS_TITLE,
    TITLE as RETURN_TITLE,
    Audits,
    never_texts,
)
from harness.results import Results
from harness.results.comparison import still_to_come
from harness.results.overview import shared_text
from harness.results.ranking import ranking_of
from harness.results.replay import shows_of
from harness.results.results import told_manifests
from harness.section import Shown, shown_sections


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
LEARNING = "Lines: means over seeds. Bands: 95% intervals. Dotted: random actions."
CROSSOVER = (
    "The cross-over is the first step after the first negative one at which the mean is not negative; it may turn "
    "negative again."
)
SHARED = {
    "learning": LEARNING,
    "crossover": CROSSOVER,
    "split": SPLIT,
    "paths": f"{PATHS} {TOTAL}",
    "forest": FOREST,
    "payoffs": PAYOFFS,
    "payoff_title": PAYOFF_TITLE,
    "pay": PAY,
    "indices": INDICES,
    "legend": LEGEND,
    "terms": TERMS,
    "alone": ALONE,
    "terms_title": TERMS_TITLE,
    "pools": POOLED,
    "ranking": RANKING,
    "ranking_title": RANKING_TITLE,
    "choice": CHOICE,
    "agreement": AGREEMENT,
    "returns": RETURNS,
    "returns_title": RETURN_TITLE,
    "promise": "",
    "bars": "",
    "is_curve_open": "",
}
"""Texts of the template."""
PROMISE = "at most 6 % of such reports say falsely that one helps or hurts"
BARS = (
    "Dot and thin bar: the difference and its interval (at least 95 %), which counts a training that was not seen; "
    "right of the line is better, and what is coloured is plain. Small dots: a training each, by the measure above "
    "them, on a scale of their own; further right is better. Thick bars are pay: right of the line is more pay, which "
    "is neither better nor worse. A training failed if its policy succeeds in less than half of its episodes; else it "
    "learned."
)


@dataclass(frozen=True, eq=False)
class Page:
    """What the template shows; what is not known is empty, and left out."""

    question: str
    comparisons: Sequence[Section]
    has: Mapping[str, bool]
    is_open: bool
    """Whether the first comparison is shown in full: one of another reward. All others are lines that open."""
    told: Mapping[str, str]
    cell_count: str
    setting: str = ""
    warnings: Sequence[str] = ()
    said: Sequence[Fact] = ()
    never: Sequence[str] = ()
    alone: Sequence[Mapping[str, Any]] = ()
    commands: Sequence[Fact] = ()
    matrix: Matrix | None = None
    groups: Sequence[Mapping[str, Any]] = ()
    pictured: bool = False
    pools: Sequence[Card] = ()
    choosing: Sequence[Fact] = ()
    ranking: Sequence[TaskRows] = ()
    unfinished: Sequence[str] = ()
    returns: Sequence[Fact] = ()
    replay: Replay | None = None
    added: Sequence[Shown] = ()
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


def write_html(results: Results, path: Path, audits: Audits = MappingProxyType({})) -> None:
    """Write the report to `path`, in one go: a reader finds the old file or the new one, whole.

    Args:
        results: The results to report.
        path: The page.
        audits: What the rewards pay for, if an audit was made.

    Raises:
        UsageError: The extra ``report`` is missing, or `path` cannot be written.
    """
    write_page(_render(results, audits), path, "The report")


def _render(results: Results, audits: Audits) -> str:
    combinations = results.combinations
    points = points_of_a_run(sum(2 * len(comparison.seeds) for comparison in combinations))
    matrix = matrix_of(combinations)
    shows = shows_of(results)
    links = links_of(shows, combinations)
    sections = [
        comparison_section(results, place, entry.place, points, audits, found)
        for place, (entry, found) in enumerate(zip(matrix.entries, links, strict=True), 1)
    ]
    is_open = sum(not it.is_control for it in combinations) < 2
    groups = groups_of([section.card for section in sections], combinations, is_open * 1)
    shown = sections[:1] if is_open else sections  # the controls beside it are lines that open
    sides = [side for section in sections if section.frames for side in section.frames.sides]
    ranking, added = list(map(task_rows, ranking_of(results).tasks)), tuple(shown_sections(results).values())
    returns = return_facts(results.returns)
    page = Page(
        question=question(results),
        setting=shared_text(combinations) if combinations else BETWEEN.join(map(setting_of, results.alone[:1])),
        warnings=_warnings(results),
        said=said_facts(results),
        never=never_texts(results),
        alone=[alone_section(results, it) for it in results.alone],
        matrix=matrix,
        comparisons=sections,
        commands=[*advice_facts(results), *beside_facts(results)],
        groups=groups,
        is_open=is_open,
        pictured=any(side.source for section in shown if section.frames for side in section.frames.sides),
        has=parts_of(shown, bool(ranking or returns or added or sections[1:])),
        told=_told(results),
        pools=pool_cards(combinations),
        choosing=choosing_facts(results),
        ranking=ranking,
        cell_count=count_cells(results),
        unfinished=[*remarks_on_cells(results), *dict.fromkeys(side.told for side in sides if not side.source)],
        returns=returns,
        replay=replay_of(shows),
        added=added,
        manifests=told_manifests(results),
        **repeat_of(results),
        downloads=[
            pack("comparisons.csv", "text/csv", comparisons_csv(combinations)),
            pack("report.json", "application/json", report_text(results)),
        ],
    )
    return render(page, "The HTML report")


def parts_of(sections: Sequence[Section], has_more: bool) -> dict[str, bool]:
    """Which parts of the page have something to show. A part that has nothing is left out.

    Args:
        sections: The comparisons that stand there in full; all of them, where none does.
        has_more: Whether there is something that is told of several comparisons together.
    """
    parts = ("behaviour", "learning", "terms", "number")
    has = {part: any(getattr(section, part) for section in sections) for part in parts}
    return {**has, "matrix": has_more or len(sections) > 1}


def _warnings(results: Results) -> list[str]:
    """What a reader must know before the answers."""
    ended = [f"{count_cells(results)}. The last part of the page has the reasons."]
    told = ended if results.failed or results.damaged else []
    return [*told, *(text for text in (interim_text(results), joined_text(results), grown_text(results)) if text)]


def _told(results: Results) -> dict[str, str]:
    """Texts that all comparisons share."""
    is_promised = any(it.answer.ruling for it in results.combinations) and not still_to_come(results.combinations)
    return {
        **SHARED,
        "subject": results.subject,
        "cells": "Cells" if results.is_experiment else "Recordings",
        "split": f"{scales_text(results.subject)} {SPLIT} {READING}",
        "tests": what_decides(results),
        "promise": PROMISE if is_promised else "",
        "bars": BARS if any(it.seeds for it in results.combinations) else "",
    }
