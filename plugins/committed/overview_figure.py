"""Every combination at a glance: eta_N and eta_P, each with ruler and behaviour."""

import textwrap
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from harness.authoring.commands import Comparison, no_splits
from harness.authoring.pages import (
    BETTER,
    CHARACTER,
    Axis,
    Chart,
    Dots,
    Line,
    Mark,
    SplitRow,
    draw_ratio,
    is_drawable,
    number_of,
    ratio_axis,
    scales_text,
    splits_of,
    tell_apart,
)

from .svg import INTERVALS, TitledChart, draw_svg

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
    shared, names = name_apart(combinations)
    labels = [_label(*given) for given in zip(names, combinations, missing, strict=True)]
    rows = list(_rows(combinations, labels))
    returned = ["eta"] if any(it.main for it in combinations) else []
    of = returned if _is_drawn("eta", rows) else [*returned, *BETTER]
    drawn = [name for name in of if _is_drawn(name, rows)]
    if not drawn:
        return None
    panels = [TitledChart(name, _chart(name, rows)) for name in drawn]
    title = "eta = ruler x behaviour of every combination"
    left_out = [_not_drawn(name, rows) for name in of if name not in drawn]
    notes = [*left_out, scales_text(combinations[0].group.subject), INTERVALS]
    return draw_svg(title, (title, shared), panels, notes)


def _is_drawn(name: str, rows: Sequence[Row]) -> bool:
    """Whether there is anything to show in the panel of an eta."""
    return any(is_drawable(part.ratio) for row in rows for part in _split(row, name))


def _not_drawn(name: str, rows: Sequence[Row]) -> str:
    """Why an eta has no panel, in words."""
    reasons = dict.fromkeys(note for row in rows if (note := _split(row, name)[0].ratio.note))
    return f"{name} is not drawn, no combination has a number that says something: {'; '.join(reasons)}."


def name_apart(combinations: Sequence[Comparison]) -> tuple[str, list[str]]:
    """What all combinations share, and for each combination what it does not share."""
    told = [_parts(combination) for combination in combinations]
    apart = tell_apart(told, keep=len(combinations[0].group.labels) if len(told) == 1 else None)
    return apart.shared, apart.names


def _parts(combination: Comparison) -> tuple[str, ...]:
    group = combination.group
    manner = f"{group.steps:,} steps, evaluated {group.manner}"
    proposed = combination.proposed + " (A/A)" * (combination.proposed == combination.baseline)
    return (*group.labels.values(), proposed, f"against {combination.baseline}", manner)


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
    split = splits_of(combination).get(name, combination.splits.get(name, NO_SPLIT))
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
