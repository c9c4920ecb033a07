"""A study of recorded trainings as one HTML file that opens anywhere, offline; its template is an experiment's."""

from pathlib import Path
from typing import Any

from harness.eta.behaviour_change import Change
from harness.eta.headline import Answer
from harness.eta.index import Ratio
from harness.eta.scored_sums import BB, KK
from harness.report.facts import repeat_of
from harness.report.figures.accumulated import draw_panels
from harness.report.figures.chart import Chart
from harness.report.figures.draw import draw_chart
from harness.report.figures.forest import EXPLANATION as FOREST
from harness.report.figures.forest import draw_strip
from harness.report.figures.learning import describe_learning, draw_learning
from harness.report.figures.points import POINTS
from harness.report.figures.split import draw_split
from harness.report.figures.split_rows import describe_split
from harness.report.page.comparison import Panel
from harness.report.page.download import pack
from harness.report.page.html import OPEN, TEMPLATE
from harness.report.page.matrix import SYMBOLS, Entry, Matrix, Sortable, anchor_of, badge_of
from harness.report.page.page import render_page, write_page
from harness.report.rows.comparison import (
    PATHS,
    SPLIT,
    TOTAL,
    Grid,
    advice,
    answer_text,
    claims_text,
    format_number,
    index_grid,
    interval_text,
    path_grid,
    ratio_grid,
    ratio_text,
    rewards_text,
    seeds_text,
    split_grid,
    sum_grid,
)
from harness.report.trainings.document import study_json
from harness.report.trainings.rows import (
    READING,
    RETURNS,
    SCALES,
    TABLE,
    TESTS,
    behaviour_grid,
    paid_grid,
    recordings_grid,
    return_splits,
    returns_grid,
    study_text,
    study_title,
    text_of,
)
from harness.results import Results
from harness.results.comparison import Comparison
from harness.results.overview import NOTHING
from harness.results.recordings.learning import learning_of
from harness.results.recordings.study import Study, basis_text

HEADINGS = ("return, baseline", "return, proposed", "eta")
LEARNING = "Lines: mean over seeds of the episodes that ended in each twentieth of the training. Bands: 95% intervals."
CROSSOVER = "The cross-over is the first step after the first negative one at which the mean is not negative again."


def write_study_page(study: Study, path: Path, results: Results | None = None) -> None:
    """Write the page to `path`, in one go: a reader finds the old file or the new one, whole.

    Args:
        study: The study to show.
        path: An HTML file.
        results: The experiment whose trainings these are; None if no experiment made them.

    Raises:
        UsageError: The extra ``report`` is missing, or `path` cannot be written.
    """
    write_page(_render(study, results), path, "The report")


def _render(study: Study, results: Results | None) -> str:
    matrix = _matrix(study)
    deciding = study.runs.measures[0].replace("_", " ") if study.runs.measures else "behaviour"
    unit = " [pp]" if study.runs.measures and study.runs.is_flag(study.runs.measures[0]) else ""
    return render_page(
        TEMPLATE,
        "The HTML report",
        question=study_title(study),
        matrix=matrix,
        shared=matrix.shared,
        headings=(*HEADINGS, f"{deciding}, baseline", f"{deciding}, proposed", f"difference{unit}"),
        success=[{} for _ in study.comparisons],
        comparisons=[_section(study, comparison, results) for comparison in study.comparisons],
        is_open=len(study.comparisons) <= OPEN,
        told={
            "subject": "agent",
            "cells": "Recordings",
            "map": f"Its {deciding}, proposed - baseline{unit}: a reward against the one above.",
            "learning": LEARNING,
            "crossover": CROSSOVER,
            "split": SPLIT,
            "paths": f"{PATHS} {TOTAL}",
            "tests": TESTS,
            "forest": FOREST,
            "returns": RETURNS,
            "payoffs": "",
            "payoff_title": "",
        },
        ranking=None,
        cell_count=study_text(study),
        unfinished=[f"{line}." for line in (*study.runs.notes, *study.runs.damaged)],
        returns={
            "title": "Every training, paid by every reward",
            "explanation": TABLE,
            "blocks": [
                (f"{RETURNS}, {manner}", paid_grid(study, manner)._replace(title="")) for manner in study.tables
            ],
            "is_open": True,
        },
        replay=None,
        transfer=None,
        recordings=recordings_grid(study),
        **repeat_of(results),
        downloads=[pack("report.json", "application/json", study_json(study))],
    )


def _section(study: Study, comparison: Comparison, results: Results | None) -> dict[str, Any]:
    """What the template shows of a comparison."""
    headline = comparison.headline
    changes = comparison.changes_of(comparison.manner)
    behaviour = [behaviour_grid(comparison, manner) for manner in comparison.episodes] if changes else []
    rewards = rewards_text(comparison)
    return {
        "title": f"{study.runs.env}: {rewards}" if len(study.comparisons) == 1 else rewards,
        "answer": answer_text(headline),
        "badge": badge_of(headline.answer),
        "symbol": SYMBOLS[headline.answer],
        "robot": f"{headline.robot} {basis_text(comparison)}".strip(),
        "number": headline.number,
        "returns": returns_grid(comparison) if comparison.seeds else None,
        "mixtures": [],
        "advice": advice(results, comparison) if results else "",
        "tests": claims_text(comparison),
        "summary": _summary(study, comparison),
        "behaviour": behaviour[0] if behaviour else None,
        "strips": [draw_strip(change) for change in changes],
        "outcomes": [],
        "episodes": [],
        "endings": [],
        "showing": [{} for _ in changes],
        "learning": _learning_panels(study, comparison),
        "splits": _split_panels(comparison),
        "curves": _curve_panels(comparison),
        "payoffs": None,
        "profiles": [],
        "other_behaviour": behaviour[1:],
        "numbers": _number_grids(study, comparison),
        "trajectories": [],
    }


def _summary(study: Study, comparison: Comparison) -> str:
    if not comparison.seeds:
        return ""
    length = f"{study.runs.steps:,} environment steps long, {seeds_text(comparison.seeds)}"
    paid = f"once paid by {comparison.baseline}, once by {comparison.proposed}"
    return f"{study.runs.env} was learned {length}: {paid}. {READING} {SCALES}"


def _panel(heading: str, chart: Chart, caption: str, what: str) -> Panel:
    return Panel(heading, draw_chart(chart, f"{what} {heading}. {caption}"), caption)


def _learning_panels(study: Study, comparison: Comparison) -> list[Panel]:
    """Every measure, then every ruler, over the training."""
    learning = learning_of(study.runs, comparison)
    if learning is None:
        return []
    texts = {change.name: text_of(change) for change in comparison.changes_of(comparison.manner)}
    panels = []
    for name in learning.random:
        if not learning.baseline.known(name) and not learning.proposed.known(name):
            continue
        text = texts.get(name, format_number)
        chart, caption = draw_learning(learning, name, text), describe_learning(learning, name, text)
        panels.append(_panel(name.replace("_", " ").capitalize(), chart, caption, "Over environment steps."))
    return panels


def _split_panels(comparison: Comparison) -> list[Panel]:
    """The return in the manner that the verdict uses, then I_N and I_P, each with its parts."""
    main = {} if comparison.main is None else {"eta": comparison.main.ratio}
    drawn = [(name, split, draw_split(name, split)) for name, split in {**main, **comparison.index_splits}.items()]
    headings = {"eta": f"Mean return {comparison.manner}: eta = ruler x behaviour"}
    return [
        _panel(
            headings.get(name, f"{name} = ruler x behaviour"),
            chart,
            describe_split(name, split),
            "Ratios on a logarithmic axis.",
        )
        for name, split, chart in drawn
        if chart is not None
    ]


def _curve_panels(comparison: Comparison) -> list[Panel]:
    """The summed reward of both trainings, each under its own reward."""
    charts = draw_panels(comparison, POINTS, "accumulated reward")
    if charts is None:
        return []
    first, crossover = index_grid(comparison.decomposition).rows[:2]
    sides = ((1, "Baseline", comparison.baseline, charts[0]), (2, "Proposed", comparison.proposed, charts[1]))
    return [
        _panel(
            f"{role}: {reward}",
            chart,
            f"First negative step: {first[column]}. Cross-over step: {crossover[column]}.",
            "Accumulated reward over environment steps.",
        )
        for column, role, reward, chart in sides
    ]


def _number_grids(study: Study, comparison: Comparison) -> list[Grid]:
    returns, splits = return_splits(comparison), comparison.index_splits
    grids = [grid(returns) for grid in (ratio_grid, split_grid, path_grid)] if returns else []
    if splits and comparison.decomposition is not None:
        grids += [grid(splits) for grid in (ratio_grid, split_grid, path_grid)]
        grids += [sum_grid(comparison.decomposition.total), index_grid(comparison.decomposition, study.kind)]
    return [grid for grid in grids if grid.rows or grid.notes]


def _matrix(study: Study) -> Matrix:
    """A map of answers. Each reward has a row, and a column for each reward that comes before it."""
    comparisons = study.comparisons
    entries = [_entry(number, comparison) for number, comparison in enumerate(comparisons)]
    found = {(it.proposed, it.baseline): entry for it, entry in zip(comparisons, entries, strict=True)}
    trained = study.runs.trained
    rows = [(proposed, [found.get((proposed, baseline)) for baseline in trained[:-1]]) for proposed in trained[1:]]
    counts = [(badge_of(it), it.value.upper(), sum(entry.badge == badge_of(it) for entry in entries)) for it in Answer]
    shared = f"{study.runs.env}, {study.runs.steps:,} steps"
    return Matrix(shared, list(trained[:-1]), rows, entries, [count for count in counts if count[2]])


def _entry(number: int, comparison: Comparison) -> Entry:
    headline, change = comparison.headline, comparison.decisive
    difference = ""
    if change is not None and change.difference is not None:
        is_share = change.measure.episodes is not None
        difference = f"{100 * change.difference:+.1f}" if is_share else f"{change.difference:+.3g}"
    return Entry(
        anchor_of(number),
        f"against {comparison.baseline}",
        comparison.proposed,
        answer_text(headline),
        badge_of(headline.answer),
        SYMBOLS[headline.answer],
        difference,
        (*_returned(comparison), *_measured(change, difference)),
    )


def _measured(change: Change | None, difference: str) -> tuple[Sortable, ...]:
    if change is None:
        return (Sortable(NOTHING, "", ""),) * 3
    text = text_of(change)
    sides = [Sortable(text(it), "", _key(it)) for it in (change.baseline, change.proposed)]
    return (*sides, Sortable(difference or NOTHING, "", _key(change.difference)))


def _returned(comparison: Comparison) -> tuple[Sortable, ...]:
    main = comparison.main
    if main is None:
        return (Sortable(NOTHING, "", ""),) * 3
    own = (main.returns[BB], main.returns[KK])
    sides = [Sortable(format_number(it.mean), "", _key(it.mean)) for it in own]
    eta: Ratio = main.ratio.eta
    return (*sides, Sortable(ratio_text(eta), interval_text(eta, missing=""), _key(eta.value)))


def _key(value: float | None) -> str:
    return "" if value is None else repr(value)
