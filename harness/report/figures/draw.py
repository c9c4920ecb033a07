"""Charts as SVG elements: no script, no fixed colour, text that can be found and read out."""

import math
from collections.abc import Callable, Iterable, Sequence
from functools import singledispatch
from typing import NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from harness.arrays import Float
from harness.report.figures.chart import Area, Axis, Chart, Dots, Flag, Line, Note, Word
from harness.report.page.page import pieces_of
from harness.text import visible

CHARACTER = 6.9
"""Width of a character of a label, [px]."""
WIDTHS = {**dict.fromkeys("0123456789", 8.0), **dict.fromkeys("−×→≤≥+=", 10.5), **dict.fromkeys(".,;:[]()", 4.9)}
"""Widths of the characters of numbers, [px]: digits are all as wide, and wider than letters are on average."""
LINE = 16.0
"""Height of a line of labels, [px]."""
SAMPLE = (26.0, 12.0)
"""Width and height of a sample in a legend, [px]."""
NOWHERE = Axis(0.0, 1.0, "", ())
BESIDE = {"start": (0.0, 1.0), "middle": (0.5, 0.5), "end": (1.0, 0.0)}
"""Which shares of a text lie before and behind its place, by the text's anchor."""
SUBSCRIPT = 3.0
"""How much lower a subscript stands, [px]."""
OFF = 4.0
"""Distance from a line to a word beside it, [px]."""


class Frame(NamedTuple):
    """Where the panel lies in the figure, [px], and what it spans."""

    chart: Chart
    left: float
    top: float
    width: float
    height: float

    def across(self, values: Sequence[float]) -> np.ndarray:
        """Where values of the horizontal axis are, [px]."""
        return self.left + self.width * _shares(self.chart.x, values)

    def down(self, values: Sequence[float]) -> np.ndarray:
        """Where values of the vertical axis are, [px]."""
        return self.top + self.height * (1.0 - _shares(self.chart.y, values))


def draw_chart(chart: Chart, label: str) -> str:
    """The figure and its legend as HTML.

    Args:
        chart: What to draw.
        label: The same in words, for those who cannot see it.
    """
    return ElementTree.tostring(draw_figure(chart, label), encoding="unicode") + _legend(chart)


def draw_figure(chart: Chart, label: str) -> Element:
    """The figure alone, an SVG element.

    Args:
        chart: What to draw.
        label: The same in words.
    """
    frame = _frame(chart)
    size = {"viewBox": f"0 0 {chart.width:g} {figure_height(chart):g}", "role": "img", "aria-label": visible(label)}
    svg = Element("svg", {"class": "chart", **size})
    _draw_axes(svg, frame)
    for mark in chart.marks:
        if not isinstance(mark, Line | Area) or len(mark.x):  # a path without points is an error to a browser
            _draw(mark, svg, frame)
    return svg


def figure_height(chart: Chart) -> float:
    """Height of the figure with all labels, without its legend, [px]."""
    frame = _frame(chart)
    return round(frame.top + frame.height + 2.6 * LINE)


def panel_left(chart: Chart) -> float:
    """Where the panel begins in the figure, [px]."""
    return _frame(chart).left


def legend_of(chart: Chart) -> list[tuple[str, Line | Dots]]:
    """Each name of the legend, and the mark that it names."""
    marks = [mark for mark in chart.marks if isinstance(mark, Line | Dots)]
    named = ((mark.legend if isinstance(mark, Dots) else mark.name * mark.in_legend, mark) for mark in marks)
    return [(name, mark) for name, mark in named if name]


def draw_sample(mark: Line | Dots) -> Element:
    """A short piece of a line, or a single dot, as an SVG element of `SAMPLE` pixels."""
    svg = Element("svg", {"class": "chart sample", "viewBox": "0 0 {:g} {:g}".format(*SAMPLE), "aria-hidden": "true"})
    frame = Frame(Chart(NOWHERE, NOWHERE, ()), 1.0, 0.0, SAMPLE[0] - 2.0, SAMPLE[1])
    if isinstance(mark, Line):
        _draw(mark._replace(x=[0.0, 1.0], y=[0.5, 0.5], name=""), svg, frame)
    else:
        _draw(mark._replace(x=[0.5], y=[0.5], names=()), svg, frame)
    return svg


def _frame(chart: Chart) -> Frame:
    """The frame of a chart: it leaves as much room as the labels need."""
    names = [text for _, text in chart.y.ticks]
    left = (LINE if chart.y.title else 0.0) + 10.0 + max(map(width_of, names), default=0.0)
    notes = [width_of(mark.text) for mark in chart.marks if isinstance(mark, Note)]
    right = 8.0 + max(width_of(chart.x.ticks[-1][1]) / 2 if chart.x.ticks else 0.0, *notes, 0.0)
    rows = [mark.row + 1 for mark in chart.marks if isinstance(mark, Flag)]
    width = chart.width - left - right
    return Frame(chart, left, 10.0 + LINE * max(rows, default=0), width, width if chart.is_square else chart.height)


def _shares(axis: Axis, values: Sequence[float]) -> np.ndarray:
    """How far along the axis values lie, 0 at its low end and 1 at its high end."""
    given = np.asarray(values, np.float64)
    if axis.is_log:
        low, high = math.log(axis.low), math.log(axis.high)
        return (np.log(given) - low) / (high - low)
    return (given - axis.low) / (axis.high - axis.low)


def _draw_axes(svg: Element, frame: Frame) -> None:
    chart, bottom, right = frame.chart, frame.top + frame.height, frame.left + frame.width
    for (value, text), x in zip(chart.x.ticks, frame.across([value for value, _ in chart.x.ticks]), strict=True):
        kind = "one" if chart.x.is_log and value == 1.0 else "grid"
        if chart.x.has_grid:
            _stroke(svg, kind, [(x, frame.top), (x, bottom)])
        _text(svg, x, bottom + LINE, text, "middle")
    for (value, text), y in zip(chart.y.ticks, frame.down([value for value, _ in chart.y.ticks]), strict=True):
        if chart.y.has_grid:
            _stroke(svg, "zero" if value == 0.0 else "grid", [(frame.left, y), (right, y)])
        _text(svg, frame.left - 7.0, y + 4.0, text, "end")
    _stroke(svg, "axis", [(frame.left, frame.top), (frame.left, bottom), (right, bottom)])
    _text(svg, frame.left + frame.width / 2, bottom + 2.2 * LINE, chart.x.title, "middle")
    if chart.y.title:
        middle = frame.top + frame.height / 2
        turned = _text(svg, 12.0, middle, chart.y.title, "middle")
        turned.set("transform", f"rotate(-90 12 {middle:.1f})")


@singledispatch
def _draw(mark: object, svg: Element, frame: Frame) -> None:
    raise TypeError(f"no mark: {mark!r}")


@_draw.register
def _(mark: Line, svg: Element, frame: Frame) -> None:
    path = _stroke(svg, f"line {mark.colour}", zip(frame.across(mark.x), frame.down(mark.y), strict=True))
    path.set("stroke-width", f"{mark.width:g}")
    if mark.opacity < 1.0:
        path.set("opacity", f"{mark.opacity:g}")
    if mark.dash:
        path.set("stroke-dasharray", mark.dash)
    _name(path, mark.name)


@_draw.register
def _(mark: Area, svg: Element, frame: Frame) -> None:
    """An area is cut off where the panel ends, since an interval of a share may go below 0."""
    up = np.clip(np.asarray(mark.y, np.float64), frame.chart.y.low, frame.chart.y.high).tolist()
    points = zip(frame.across(mark.x), frame.down(up), strict=True)
    SubElement(svg, "path", {"class": f"area {mark.colour}", "d": f"{_path(points)}Z"})


@_draw.register
def _(mark: Dots, svg: Element, frame: Frame) -> None:
    names = mark.names or ("",) * len(mark.x)
    kind = f"dot {mark.colour}{' open' if mark.is_open else ''}"
    for x, y, name in zip(frame.across(mark.x), frame.down(mark.y), names, strict=True):
        shape = SubElement(svg, "path", {"class": kind, "d": SHAPES[mark.shape](x, y, mark.size)})
        _name(shape, name)


@_draw.register
def _(mark: Word, svg: Element, frame: Frame) -> None:
    x, y = frame.across([mark.x])[0], frame.down([mark.y])[0]
    before, behind = BESIDE[mark.anchor]
    long, beside = width_of(mark.text), x + OFF * (behind - before)
    inside = max(frame.left + OFF + before * long, min(beside, frame.left + frame.width - OFF - behind * long))
    _text(svg, inside, y + 4.0 - mark.rise, mark.text, mark.anchor).set("class", "word")


@_draw.register
def _(mark: Note, svg: Element, frame: Frame) -> None:
    (y,) = frame.down([mark.y])
    _text(svg, frame.left + frame.width + 7.0, y + 4.0, mark.text, "start")


@_draw.register
def _(mark: Flag, svg: Element, frame: Frame) -> None:
    """The text stands above the panel, where no curve can cover it, towards the middle."""
    (x,) = frame.across([mark.x])
    _stroke(svg, "flag", [(x, frame.top), (x, frame.top + frame.height)])
    begins = x < frame.left + frame.width / 2
    _text(svg, x, frame.top - 5.0 - LINE * mark.row, mark.text, "start" if begins else "end")


def _circle(x: float, y: float, size: float) -> str:
    return f"M{x - size:.1f} {y:.1f}a{size:g} {size:g} 0 1 0 {2 * size:g} 0a{size:g} {size:g} 0 1 0 {-2 * size:g} 0Z"


def _square(x: float, y: float, size: float) -> str:
    return f"M{x - size:.1f} {y - size:.1f}h{2 * size:g}v{2 * size:g}h{-2 * size:g}Z"


def _diamond(x: float, y: float, size: float) -> str:
    side = 1.25 * size
    return f"M{x:.1f} {y - side:.1f}l{side:g} {side:g}l{-side:g} {side:g}l{-side:g} {-side:g}Z"


def _cross(x: float, y: float, size: float) -> str:
    there = f"M{x - size:.1f} {y - size:.1f}l{2 * size:g} {2 * size:g}"
    return f"{there}M{x - size:.1f} {y + size:.1f}l{2 * size:g} {-2 * size:g}"


SHAPES: dict[str, Callable[[float, float, float], str]] = {
    "circle": _circle,
    "square": _square,
    "diamond": _diamond,
    "cross": _cross,
}


def _legend(chart: Chart) -> str:
    """Names beside a sample of each line and dot, as a list that wraps; empty where nothing has a name."""
    rows = Element("ul", {"class": "legend"})
    for name, mark in legend_of(chart):
        row = SubElement(rows, "li")
        row.append(draw_sample(mark))
        SubElement(row, "span").text = "".join(it.text for it in pieces_of(visible(name)))
    return ElementTree.tostring(rows, encoding="unicode") if len(rows) else ""


def _stroke(svg: Element, kind: str, points: Iterable[tuple[float, float]]) -> Element:
    return SubElement(svg, "path", {"class": kind, "d": _path(points)})


def _path(points: Iterable[tuple[float, float]]) -> str:
    """A path straight from point to point, in tenths of a pixel. A point that is NaN interrupts it.

    Each point is written as its distance from the point before. That saves a megabyte on a page of many figures.
    """
    given = np.array(list(points), np.float64).reshape(-1, 2)
    missing = np.isnan(given).any(axis=1)
    stretches = np.split(given, np.flatnonzero(missing))
    return "".join(_stretch(known) for it in stretches if len(known := it[~np.isnan(it).any(axis=1)]))


def _stretch(points: Float) -> str:
    """A path through points, (n, 2) with n >= 1."""
    whole = np.rint(10.0 * points).astype(int)
    steps = np.diff(whole, axis=0).tolist()
    begin = f"M{_tenths(whole[0, 0])} {_tenths(whole[0, 1])}"
    return begin + ("l" + " ".join(f"{_tenths(x)} {_tenths(y)}" for x, y in steps) if steps else "")


def _tenths(count: int) -> str:
    """A number of tenths: 12 is 1.2, 3 is .3, 20 is 2."""
    text = f"{count / 10:g}"
    return text.replace("0.", ".", 1) if abs(count) < 10 else text


def _text(svg: Element, x: float, y: float, text: str, anchor: str) -> Element:
    element = SubElement(svg, "text", {"x": f"{x:.1f}", "y": f"{y:.1f}", "text-anchor": anchor})
    set_text(element, text)
    return element


def width_of(text: str) -> float:
    """About how wide a text is, [px]."""
    return sum(WIDTHS.get(character, CHARACTER) for piece in pieces_of(visible(text)) for character in piece.text)


def set_text(element: Element, text: str) -> None:
    """Write a text into an SVG element, with its signs and subscripts."""
    lowered = False
    for piece in pieces_of(visible(text)):
        if piece.is_subscript == lowered and not len(element):
            element.text = piece.text
            continue
        span = SubElement(element, "tspan", {"dy": f"{SUBSCRIPT if piece.is_subscript else -SUBSCRIPT:g}"})
        span.text, lowered = piece.text, piece.is_subscript
        if lowered:
            span.set("font-size", "75%")


def _name(element: Element, name: str) -> None:
    """Give an element a name, which is shown under the pointer."""
    if name:
        SubElement(element, "title").text = visible(name)
