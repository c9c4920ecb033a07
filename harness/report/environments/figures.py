"""The figures of a comparison on a study's page, as files: learning, ruler x behaviour, accumulated reward."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from harness.eta.headline import count_seeds
from harness.report.figures.accumulated import draw_panels
from harness.report.figures.learning import describe_learning, draw_learning
from harness.report.figures.points import FEWEST, POINTS
from harness.report.figures.split import draw_split
from harness.report.figures.split_rows import describe_split
from harness.report.rows.behaviour import Text
from harness.report.rows.comparison import format_number, rewards_text
from harness.report.summary.figures import OF_ALL_RUNS, RUNS
from harness.report.summary.svg import INTERVALS, Panel, draw_svg
from harness.report.trainings.rows import RETURNS, text_of
from harness.results.comparison import Comparison
from harness.results.learning import Learning
from harness.results.recordings.learning import learning_of, return_name
from harness.results.recordings.places import PlaceStudy
from harness.results.recordings.study import Study
from harness.text import file_stems

PAID = "return, as paid"
PANELS = 3
"""How many panels a figure of learning has, side by side: the return, and the first measures of behaviour."""
WIDTH = 360.0
"""Width of one of these panels, [px]."""
LEARNING = (
    "Lines: means over seeds of the episodes that ended in each twentieth of the training, each paid by its own "
    "reward. Bands: 95% intervals."
)


class Figure(NamedTuple):
    """A figure as a file."""

    name: str
    shows: str
    content: bytes


def figures_of(studies: Sequence[PlaceStudy]) -> dict[Comparison, list[Figure]]:
    """The figures of every comparison, as SVG files. A figure without any value is left out."""
    told = [(it.title, it.study, comparison) for it in studies if it.study for comparison in it.study.comparisons]
    stems = file_stems(f"{title} {it.proposed} against {it.baseline}" for title, _, it in told)
    return {given[-1]: _figures(*given, stem) for given, stem in zip(told, stems, strict=True)}


def _figures(title: str, study: Study, comparison: Comparison, stem: str) -> list[Figure]:
    if not comparison.seeds:
        return []
    headline = (title, f"{rewards_text(comparison)}, {count_seeds(len(comparison.seeds))}")
    drawn = (
        ("learning", "Return and behaviour while learning", _learning(headline, study, comparison)),
        ("split", "eta as ruler x behaviour", _split(headline, comparison)),
        ("runs", "Accumulated reward of every training and their mean", _runs(headline, comparison)),
    )
    return [Figure(f"{stem}.{what}.svg", shows, content) for what, shows, content in drawn if content is not None]


def _learning(headline: Sequence[str], study: Study, comparison: Comparison) -> bytes | None:
    """The paid return and the first measures of behaviour over environment steps, a line for each reward."""
    learning = learning_of(study.runs, comparison)
    if learning is None:
        return None
    learning = _with_paid(learning)
    texts: dict[str, Text] = {change.name: text_of(change) for change in comparison.changes_of(comparison.manner)}
    names = [name for name in (PAID, *study.runs.measures) if _is_known(learning, name)][:PANELS]
    charts = {name: draw_learning(learning, name, texts.get(name, format_number)) for name in names}
    told = [f"{_heading(name)}: {describe_learning(learning, name, texts.get(name, format_number))}" for name in names]
    panels = [Panel(_heading(name), chart._replace(width=WIDTH)) for name, chart in charts.items()]
    return _file("Learning", headline, panels, [LEARNING, *told]) if panels else None


def _with_paid(learning: Learning) -> Learning:
    """The same learning with one more curve for each reward: what each training was paid."""
    baseline, proposed = (
        replace(curve, points={PAID: curve.points[return_name(curve.reward)], **curve.points})
        for curve in (learning.baseline, learning.proposed)
    )
    return Learning(baseline, proposed, {PAID: None, **learning.random})


def _is_known(learning: Learning, name: str) -> bool:
    return bool(learning.baseline.known(name) or learning.proposed.known(name))


def _heading(name: str) -> str:
    return name.replace("_", " ").capitalize()


def _split(headline: Sequence[str], comparison: Comparison) -> bytes | None:
    """The figure of ruler x behaviour: the eta of the mean return, then those of I_N and I_P, each with its parts."""
    main = {} if comparison.main is None else {"eta": comparison.main.ratio}
    splits = {**main, **comparison.index_splits}
    headings = {"eta": f"{RETURNS} {comparison.manner}: eta = ruler x behaviour"}
    drawn = {name: draw_split(name, split) for name, split in splits.items()}
    panels = [
        Panel(headings.get(name, f"{name} = ruler x behaviour"), chart)
        for name, chart in drawn.items()
        if chart is not None
    ]
    told = [describe_split(name, split) for name, split in splits.items()]
    return _file("Ruler x behaviour", headline, panels, [*told, INTERVALS]) if panels else None


def _runs(headline: Sequence[str], comparison: Comparison) -> bytes | None:
    """The summed reward of every training, each under its own reward, and their mean."""
    points = max(FEWEST, min(POINTS, OF_ALL_RUNS // (2 * len(comparison.seeds))))
    charts = draw_panels(comparison, points, "accumulated reward")
    if charts is None:
        return None
    headings = (f"Baseline: {comparison.baseline}", f"Proposed: {comparison.proposed}")
    panels = [Panel(heading, chart) for heading, chart in zip(headings, charts, strict=True)]
    return _file("Accumulated reward", headline, panels, [RUNS])


def _file(what: str, headline: Sequence[str], panels: Sequence[Panel], notes: Sequence[str]) -> bytes:
    return draw_svg(f"{what}: {', '.join(headline)}", (what, *headline), panels, notes)
