"""What a figure shows, before it is drawn: two axes, and marks in the units of these axes.

A colour is named by what it stands for, such as ``baseline``: the page's style sheet gives it a value for a light
screen and one for a dark one; a file of its own has those of a light screen.
"""

import math
import re
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Literal, NamedTuple, TypeAlias

STYLE = Path(__file__).parent / "palette.css"
CHART = Path(__file__).parent / "chart.css"
SIDES = ("baseline", "proposed", "orange", "sky")
"""The names of the colours of policies beside one another: the baseline, the proposed reward, others."""
COLOUR = re.compile(r"--([\w-]+): ([^;]+);")


@cache
def light_colours() -> dict[str, str]:
    """Every colour of a light screen, such as ``#1f5fbf``, by its name in the style sheet, without the dashes."""
    return dict(COLOUR.findall(STYLE.read_text(encoding="utf-8").partition("}")[0]))


def chart_style() -> str:
    """The page's style rules for charts, with the colours of the light screen in place of their names."""
    colours, rules = light_colours(), CHART.read_text(encoding="utf-8")
    return re.sub(r"var\(--([\w-]+)\)", lambda name: colours[name[1]], rules)


Shape: TypeAlias = Literal["circle", "square", "diamond", "cross"]

WIDTH = 440.0
"""Width of a figure on a page, [px]. A narrower column shows it smaller."""
GAP = math.nan
"""A coordinate at which a line is interrupted."""


class Axis(NamedTuple):
    """An axis: its range, and what is written along it."""

    low: float
    high: float
    title: str
    ticks: tuple[tuple[float, str], ...]
    is_log: bool = False
    has_grid: bool = True


class Line(NamedTuple):
    """A line through points, in order."""

    x: Sequence[float]
    y: Sequence[float]
    colour: str
    name: str = ""
    """Shown under the pointer; in the legend if `in_legend`."""
    width: float = 2.0
    opacity: float = 1.0
    dash: str = ""
    """Lengths of strokes and gaps, [px]; empty for a whole line."""
    in_legend: bool = False


class Area(NamedTuple):
    """The area that points enclose."""

    x: Sequence[float]
    y: Sequence[float]
    colour: str


class Dots(NamedTuple):
    """One shape at each point."""

    x: Sequence[float]
    y: Sequence[float]
    colour: str
    names: tuple[str, ...] = ()
    """A name for each dot, shown under the pointer."""
    shape: Shape = "circle"
    is_open: bool = False
    size: float = 4.0
    """Half the width of a dot, [px]."""
    legend: str = ""
    """The name in the legend; empty if it has none."""


class Word(NamedTuple):
    """A text at a point."""

    x: float
    y: float
    text: str
    anchor: Literal["start", "middle", "end"] = "middle"
    rise: float = 0.0
    """How far the text stands above the point, [px]. A text that would leave the panel is moved to the side."""


class Note(NamedTuple):
    """A text to the right of the panel."""

    y: float
    text: str


class Flag(NamedTuple):
    """A vertical line, with a text above the panel."""

    x: float
    text: str
    row: int = 0
    """The row of the text, counted upwards."""


Mark: TypeAlias = Line | Area | Dots | Word | Note | Flag


class Chart(NamedTuple):
    """A figure with one panel."""

    x: Axis
    y: Axis
    marks: tuple[Mark, ...]
    """The marks, from the lowest to the topmost."""
    height: float = 190.0
    """Height of the panel, [px]."""
    is_square: bool = False
    """Whether the panel is as high as it is wide. `height` has no effect then."""
    width: float = WIDTH
    """Width of the figure, with all labels, [px]."""


def round_ticks(low: float, high: float, most: int = 6) -> list[float]:
    """Round numbers from `low` to `high`, evenly apart, `most` at most."""
    span = high - low
    size = 10.0 ** math.floor(math.log10(span / most))
    step = next(size * digit for digit in (1, 2, 2.5, 5, 10, 20) if span / (size * digit) < most)
    first = math.ceil(low / step - 1e-9)
    last = math.floor(high / step + 1e-9)
    return [float(f"{place * step:.12g}") for place in range(first, last + 1)]


def linear_axis(low: float, high: float, title: str, most: int = 6) -> Axis:
    """An axis with plain numbers."""
    return Axis(low, high, title, tuple((tick, f"{tick:,.12g}") for tick in round_ticks(low, high, most)))


def share_axis(title: str) -> Axis:
    """An axis from 0 to 1, with percentages."""
    return Axis(-0.02, 1.02, title, tuple((tick, f"{tick:.0%}") for tick in (0.0, 0.25, 0.5, 0.75, 1.0)))
