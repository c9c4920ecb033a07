"""The page's figures as files: of each combination, and of all combinations at a glance.

Each is an SVG file with all that tells what it shows. `missing` tells of cells that are not done.
"""

import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np

from harness.eta.headline import is_drawable, percentage
from harness.eta.splits import no_splits
from harness.report import (
    Axis,
    Chart,
    Dots,
    Line,
    describe_learning,
    describe_split,
    draw_learning,
    format_number,
    scales_text,
)
from harness.report.figures.accumulated import FEWEST, POINTS, CurvePanel, draw_both, panels_of, reward_range
from harness.report.figures.chart import Mark
from harness.report.figures.draw import CHARACTER
from harness.report.figures.learning import flat_text, learning_heading, learning_names
from harness.report.figures.split import SplitRow, draw_ratio, draw_split, number_of, ratio_axis
from harness.report.rows.comparison import compared_text, rewards_text, seeds_text, text_of
from harness.report.rows.ratios import BETTER
from harness.report.rows.returns import PAY, splits_of
from harness.results import Comparison
from harness.results.learning import Learning
from harness.results.overview import line_names, shared_text

from .svg import INTERVALS, TitledChart, draw_svg

OF_ALL_RUNS = 8_000
"""The most points of all runs in a figure together, about 70 kB."""
PANELS = 3
"""How many panels the figure of learning has at most."""
Panels: TypeAlias = tuple[CurvePanel, CurvePanel]
Texts: TypeAlias = Mapping[str, Callable[[float | None], str]]
"""Measures, and how each is written."""
FLAT = 0.03
"""Curves that span less of the axis than this share look like a line."""
RUNS = (
    "Thin: one run per seed. Thick: their mean, which the indices are taken from. Shaded: Ω₁ below 0, which I_N sums, "
    "and Ω₂ above 0, which I_P sums."
)
LEARNING = "Lines: means over seeds. Bands: 95% intervals."


def runs_file(combination: Comparison, missing: str = "") -> bytes | None:
    """The figure of accumulated reward: all runs and their mean, a panel per reward; None without a finished pair.

    Args:
        combination: What was compared.
        missing: Which of its cells are not done.
    """
    points = max(FEWEST, min(POINTS, OF_ALL_RUNS // (2 * max(1, len(combination.seeds)))))
    panels = panels_of(combination, points)
    if panels is None:
        return None
    headings = (f"Baseline: {combination.baseline}", f"Proposed: {combination.proposed}")
    titled = [TitledChart(heading, chart) for heading, chart in zip(headings, draw_both(panels), strict=True)]
    return _file("Accumulated reward", combination, missing, titled, [RUNS, *_flat(panels)])


def _flat(panels: Panels) -> Iterator[str]:
    """What is said of curves that are a line on the scale that both panels have."""
    low, high = reward_range(panels)
    for panel in panels:
        values = np.concatenate([run.values for run in panel.runs])
        if np.ptp(values) < FLAT * (high - low):
            yield f"On the scale of both panels the curves of {panel.reward} cannot be told from a line."


def split_file(combination: Comparison, missing: str = "") -> bytes | None:
    """The figure of every eta and its parts, each with its interval; None if no part of any can be drawn."""
    splits = splits_of(combination)
    drawn = {name: draw_split(name, split) for name, split in splits.items()}
    headings = {"eta": f"{PAY}, {combination.manner}: ruler x behaviour"}
    panels = [
        TitledChart(headings.get(name, f"{name} = ruler x behaviour"), chart)
        for name, chart in drawn.items()
        if chart is not None
    ]
    if not panels:
        return None
    told = [
        describe_split(name, it) if drawn[name] else f"{name} is not drawn: {it.eta.note or 'no part has a number'}."
        for name, it in splits.items()
    ]
    return _file("Ruler x behaviour", combination, missing, panels, [*told, INTERVALS])


def measures_of(combination: Comparison, learning: Learning | None) -> Texts:
    """The measures that the figure of learning shows, and how each is written."""
    names = learning_names(learning, combination)[:PANELS] if learning else []
    shares = [
        it.name for it in combination.measured.changes_of(combination.manner) if text_of(it.measure) is percentage
    ]
    return {name: percentage if name in shares else format_number for name in names}


def learning_file(combination: Comparison, learning: Learning, measures: Texts, missing: str = "") -> bytes | None:
    """The figure of some measures over environment steps, under both rewards; None if nothing happens in any.

    Args:
        combination: What was compared.
        learning: How it learned.
        measures: See `measures_of`.
        missing: Which of its cells are not done.
    """
    flat = {name: flat_text(learning, name, text) for name, text in measures.items()}
    texts = {name: text for name, text in measures.items() if not flat[name]}
    if not texts:
        return None
    told = [f"{learning_heading(name)}: {describe_learning(learning, name, text)}" for name, text in texts.items()]
    panels = [TitledChart(learning_heading(name), draw_learning(learning, name, it)) for name, it in texts.items()]
    notes = [LEARNING, *told, *filter(None, flat.values())]
    return _file("Learning", combination, missing, panels, notes, compared_text(combination))


def flat_words(learning: Learning, measures: Texts) -> str:
    """What is said in the place of a figure of learning in which nothing happens; empty where nothing is known."""
    return " ".join(filter(None, (flat_text(learning, name, text) for name, text in measures.items())))


def _file(
    what: str, combination: Comparison, missing: str, panels: list[TitledChart], notes: list[str], compared: str = ""
) -> bytes:
    """A figure as a file. Above its panels stands what was compared where, over how many seeds, and what is missing.

    Pay is compared on the seeds that both rewards have; `compared` says what is, where that is not so.
    """
    where, rewards = combination.group.title, rewards_text(combination)
    seeds = (compared or seeds_text(combination.seeds)) + (f"; {missing}" if missing else "")
    return draw_svg(f"{what}: {where}: {rewards}", (what, where, f"{rewards}, {seeds}"), panels, notes)


NAME = 44
"""The most characters in a line of a name."""
LINE = 18.0
"""Distance from one number to the next, [px]."""
AIR = 0.8
"""Space between two combinations, in lines."""
WIDTH = 400.0
"""Width of a panel with its numbers, [px]."""
LEGEND = {"eta": "eta, equal to", "ruler": "ruler times", "behaviour": "behaviour"}


NO_SPLIT = no_splits("not known")["eta_N"]
"""The split of a comparison without a mean return."""


class Row(NamedTuple):
    """A combination and where it stands, in lines from the top."""

    combination: Comparison
    label: list[str]
    top: float
    bottom: float

    @property
    def middle(self) -> float:
        """The middle between top and bottom."""
        return (self.top + self.bottom) / 2


def draw_overview(combinations: Sequence[Comparison], missing: Sequence[str]) -> bytes | None:
    """A row per combination, as SVG; None if no combination has a ratio that can be drawn.

    Args:
        combinations: Rows, from top to bottom; one without a finished pair has a row too.
        missing: For each combination, which of its cells are not done.
    """
    if not any(combination.seeds for combination in combinations):
        return None
    labels = [_label(*given) for given in zip(line_names(combinations), combinations, missing, strict=True)]
    rows = list(_rows(combinations, labels))
    returned = ["eta"] if any(it.number.main for it in combinations) else []
    of = returned if _is_drawn("eta", rows) else [*returned, *BETTER]
    drawn = [name for name in of if _is_drawn(name, rows)]
    if not drawn:
        return None
    panels = [TitledChart(name, _chart(name, rows)) for name in drawn]
    title = "eta = ruler x behaviour of every combination"
    left_out = [_not_drawn(name, rows) for name in of if name not in drawn]
    notes = [*left_out, scales_text(combinations[0].group.subject), INTERVALS]
    return draw_svg(title, (title, shared_text(combinations)), panels, notes)


def _is_drawn(name: str, rows: Sequence[Row]) -> bool:
    """Whether there is anything to show in the panel of an eta."""
    return any(is_drawable(part.ratio) for row in rows for part in _split(row, name))


def _not_drawn(name: str, rows: Sequence[Row]) -> str:
    """Why an eta has no panel, in words."""
    reasons = dict.fromkeys(note for row in rows if (note := _split(row, name)[0].ratio.note))
    return f"{name} is not drawn, no combination has a number that says something: {'; '.join(reasons)}."


def _label(name: str, combination: Comparison, missing: str) -> list[str]:
    count = len(combination.seeds)
    told = [name, f"{count} seed{'s' * (count != 1)}" + (f"; {missing}" if missing else "")]
    return [line for text in told for line in textwrap.wrap(text, NAME)]


def _rows(combinations: Sequence[Comparison], labels: Sequence[list[str]]) -> Iterator[Row]:
    """The rows, one below the other. Each is as high as its three numbers or its name."""
    top = 0.0
    for combination, label in zip(combinations, labels, strict=True):
        bottom = top + max(3, len(label)) + AIR
        yield Row(combination, label, top, bottom)
        top = bottom


def _chart(name: str, rows: Sequence[Row]) -> Chart:
    """The panel of an eta."""
    parts = [part for row in rows for part in _split(row, name)]
    ratios = ratio_axis(name, parts)
    names = [place for row in rows for place in _places(row)]
    between = [Line([ratios.low, ratios.high], [-row.top] * 2, "random", width=0.5) for row in rows[1:]]
    width = WIDTH + CHARACTER * max((len(line) for _, line in names), default=0)
    height = rows[-1].bottom
    places = Axis(-height, 0.0, "", tuple(names), has_grid=False)
    return Chart(ratios, places, (*between, *_marks(parts, ratios)), height=LINE * height, width=width)


def _places(row: Row) -> list[tuple[float, str]]:
    """The places of the lines of a row's label, around its middle."""
    first = row.middle - (len(row.label) - 1) / 2
    return [(-(first + number), line) for number, line in enumerate(row.label)]


def _split(row: Row, name: str) -> list[SplitRow]:
    """An eta and the means of both paths. The combination's own figure shows the paths."""
    combination, place = row.combination, row.middle
    split = splits_of(combination).get(name, combination.number.splits.get(name, NO_SPLIT))
    return [
        SplitRow("eta", split.eta, place - 1.0, "ink", "circle"),
        SplitRow("ruler", split.ruler, place, "ruler", "square"),
        SplitRow("behaviour", split.behaviour, place + 1.0, "behaviour", "diamond"),
    ]


def _marks(parts: Iterable[SplitRow], ratios: Axis) -> Iterator[Mark]:
    """The marks of ratios. The number of each, or a word in its place, stands beside the panel."""
    for part in parts:
        for mark in draw_ratio(part, ratios):
            yield mark._replace(legend=LEGEND[part.label]) if isinstance(mark, Dots) else mark
        yield number_of(part)
