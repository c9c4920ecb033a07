"""Figures of ratios and changes: an eta, a mean return, and what they split into, each with its interval."""

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from harness.eta.behaviour_change import Change
from harness.eta.headline import (
    difference_of,
    estimate_text,
    format_number,
    is_drawable,
    value_text,
)
from harness.eta.index import Estimate
from harness.eta.splits import Split, SumSplit
from harness.report.figures.chart import Axis, Chart, Dots, Line, Mark, Note, Shape, linear_axis
from harness.report.rows.ratios import NEITHER, better_of

PATHS = (("proposed runs", 3.5), ("baseline's runs", 6.7))
"""The names of both paths, and where their rows begin, counted down from the top."""


class SplitRow(NamedTuple):
    """One ratio of a split."""

    label: str
    ratio: Estimate
    place: float
    """The place of the row, counted down from the top."""
    colour: str
    """The name of its colour, as in `harness.report.figures.chart`."""
    shape: Shape
    is_open: bool = False
    """Whether the ratio is that of a single path, which is drawn as an open dot."""


def split_rows(name: str, split: Split) -> list[SplitRow]:
    """An eta, its split, and both paths whose mean the split is, from top to bottom."""
    rows = [
        SplitRow(name, split.eta, 0.0, "ink", "circle"),
        SplitRow("ruler", split.ruler, 1.2, "ruler", "square"),
        SplitRow("behaviour", split.behaviour, 2.2, "behaviour", "diamond"),
    ]
    for (where, top), path in zip(PATHS, split.paths, strict=False):
        rows += [
            SplitRow(f"ruler, {where}", path.ruler, top + 0.9, "ruler", "square", True),
            SplitRow(f"behaviour, {where}", path.behaviour, top + 1.9, "behaviour", "diamond", True),
        ]
    return rows


def describe_split(name: str, split: Split) -> str:
    """The same in words."""
    parts = f"ruler {value_text(split.ruler)} x behaviour {value_text(split.behaviour)}"
    return f"{name} {value_text(split.eta)} = {parts}; interaction {value_text(split.interaction)}."


FARTHEST = 30.0
"""An interval is drawn at most this factor beyond the outermost ratio. Numbers beside it say where it ends."""
TICKS = ((0.45, (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 7, 8, 9)), (1.0, (1, 1.5, 2, 3, 5, 7)), (2.2, (1, 2, 5)))
"""Which digits are marked if the axis spans at most so many decades. On a longer axis only powers of ten are marked."""

ROOM = 26
"""The fewest characters that have room along the axis, since numbers with their intervals may stand beside it."""


def ratio_range(ratios: Sequence[Estimate]) -> tuple[float, float]:
    """The range of the axis: every ratio, every interval up to `FARTHEST`, 1, and some margin."""
    drawn = [ratio for ratio in ratios if is_drawable(ratio)]
    values = [ratio.value for ratio in drawn if ratio.value is not None]
    ends = [end for ratio in drawn for end in (ratio.low, ratio.high) if end is not None]
    low, high = min([0.85, *values]), max([1.18, *values])
    low = min([low, *(max(end, low / FARTHEST) for end in ends)])
    high = max([high, *(min(end, high * FARTHEST) for end in ends)])
    air = (high / low) ** 0.08
    return low / air, high * air


def interval_ends(ratio: Estimate, low: float, high: float) -> tuple[float, float] | None:
    """The ends of a ratio's interval on an axis from `low` to `high`; None if it has no interval."""
    if ratio.low is None or ratio.high is None:
        return None
    return max(ratio.low, low), min(ratio.high, high)


def ticks(low: float, high: float) -> list[float]:
    """Round numbers between `low` and `high`, few enough to be read. 1 is among them if it lies in the range."""
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    decades = math.log10(high / low)
    digits = next((digits for most, digits in TICKS if decades <= most), None)
    if digits is None:
        step = math.ceil(decades / 6)
        values = [10.0**power for power in range(first, last + 1) if power % step == 0]
    else:
        values = [digit * 10.0**power for power in range(first, last + 1) for digit in digits]
    return [float(f"{value:.3g}") for value in values if low <= value <= high]


def named_ticks(low: float, high: float) -> tuple[tuple[float, str], ...]:
    """The `ticks` whose names have room. Every second one is left out until no names touch; 1 always stays."""
    marks = ticks(low, high)
    while len(marks) > 2 and any(_touch(*pair, high / low) for pair in pairwise(marks)):
        marks = marks[marks.index(1.0) % 2 :: 2]
    return tuple((mark, _name(mark)) for mark in marks)


def _touch(left: float, right: float, span: float) -> bool:
    """Whether the names of two ticks are less than a character apart, on an axis of which `span` is high over low."""
    apart = ROOM * math.log(right / left) / math.log(span)
    return apart < (len(_name(left)) + len(_name(right))) / 2 + 1


def _name(mark: float) -> str:
    """The name of a tick: its number. A power of ten that is long in digits is written like 1e-4 or 1e5."""
    return f"{mark:,g}" if 0.001 <= mark <= 1_000 else f"1e{math.log10(mark):.0f}"


ROWS: tuple[tuple[str, str, Shape], ...] = (
    ("change", "ink", "circle"),
    ("ruler", "ruler", "square"),
    ("behaviour", "behaviour", "diamond"),
)
"""Name, colour and shape of each part, from top to bottom."""


def draw_sum(split: SumSplit) -> Chart | None:
    """The figure of a change and its parts on one axis; None if not all of them are known."""
    parts = [getattr(split, name) for name, *_ in ROWS]
    ends = [end for part in parts for end in (part.value, part.low, part.high) if end is not None]
    if any(part.value is None for part in parts):
        return None
    low, high = min(0.0, *ends), max(0.0, *ends)
    air = 0.05 * (high - low) or 1.0
    axis = linear_axis(low - air, high + air, "return of an episode, proposed - baseline", 5)
    names = tuple((-float(place), name) for place, (name, *_) in enumerate(ROWS))
    zero: Mark = Line([0.0, 0.0], [-2.6, 0.6], "ink", width=1.0)
    marks = [mark for place, row in enumerate(ROWS) for mark in _marks(row, parts[place], -float(place))]
    return Chart(axis, Axis(-2.6, 0.6, "", names, has_grid=False), (zero, *marks), height=100.0)


def describe_sum(split: SumSplit) -> str:
    """The same in words."""
    change, ruler, behaviour = (format_number(it.value) for it in (split.change, split.ruler, split.behaviour))
    return f"Change {change} = ruler {ruler} + behaviour {behaviour}."


def _marks(row: tuple[str, str, Shape], part: Estimate, place: float) -> list[Mark]:
    name, colour, shape = row
    told = estimate_text(part)
    dots = Dots([part.value or 0.0], [place], colour, (f"{name}: {told}",), shape, size=4.5)
    bar = [] if part.low is None or part.high is None else [Line([part.low, part.high], [place] * 2, colour)]
    return [*bar, dots, Note(place, told)]


WIDTH, HEIGHT = 168.0, 18.0
"""Width and height of one row, [px]."""
REACH = 74.0
"""Distance from 0 in the middle to the farthest end, [px]."""
MIDDLE = WIDTH / 2
NO_CHANGE = ("path", {"class": "one", "d": f"M{MIDDLE:g} 0V{HEIGHT:g}"})
"""The line in the middle."""


def draw_strip(change: Change) -> str:
    """A row of the forest plot as an SVG element; empty if there is no difference to show, or nobody says its sides."""
    if change.difference is None or not change.measure.better:
        return ""
    return draw_interval(change, change.direction)


def draw_interval(change: Change, direction: str) -> str:
    """The difference and its interval as an SVG element, with what is better on the right.

    Args:
        change: What changed.
        direction: ``better`` or ``worse`` where a test says so, else empty.
    """
    kind, shapes = direction or "undecided", [NO_CHANGE]
    difference, ends = difference_of(change), [end for end in (change.low, change.high) if end is not None]
    reach, farthest = REACH * _side(change.measure.better), max(map(abs, [difference, *ends])) or 1.0
    if len(ends) == 2:
        left, right = sorted(MIDDLE + reach * end / farthest for end in ends)
        bar = {"class": f"line {kind}", "stroke-width": "2", "d": f"M{left:.1f} {HEIGHT / 2:g}H{right:.1f}"}
        shapes.append(("path", bar))
    at = {"cx": f"{MIDDLE + reach * difference / farthest:.1f}", "cy": f"{HEIGHT / 2:g}", "r": "4"}
    return _drawn(*shapes, ("circle", {"class": f"dot {kind}", **at}))


def draw_trainings(values: Sequence[float], ends: tuple[float, float], better: str, who: str) -> str:
    """A dot for each training as an SVG element, with what is better on the right.

    Args:
        values: The measure of each training.
        ends: The smallest and the largest value that the picture has room for.
        better: Whether ``higher`` or ``lower`` is better.
        who: The class of the colour, ``baseline`` or ``proposed``.
    """
    low, high = ends
    places = [(2.0 * value - low - high) / (high - low) if high > low else 0.0 for value in values]
    across = (f"{MIDDLE + REACH * _side(better) * place:.1f}" for place in places)
    kind, y = f"training {who}", f"{HEIGHT / 2:g}"
    return _drawn(*(("circle", {"class": kind, "cx": x, "cy": y, "r": "3.5"}) for x in across))


def draw_part(size: float, farthest: float, name: str) -> str:
    """A bar from no change to a part of a change, as an SVG element.

    Args:
        size: How large the part is, to the right if it is above 0.
        farthest: The largest part, which the picture has room for.
        name: Of its colour, such as ``ruler``.
    """
    end = MIDDLE + REACH * size / (farthest or 1.0)
    left, width = min(MIDDLE, end), max(abs(end - MIDDLE), 1.0)
    bar = {"class": f"bar {name}", "x": f"{left:.1f}", "y": "4", "width": f"{width:.1f}", "height": "10"}
    return _drawn(("rect", bar), NO_CHANGE)


def _side(better: str) -> float:
    """1 where more is better, else -1: what is better stands on the right."""
    return 1.0 if better == "higher" else -1.0


def _drawn(*shapes: tuple[str, dict[str, str]]) -> str:
    """A row: SVG elements with their attributes, the lowest first."""
    svg = Element("svg", {"class": "chart strip", "viewBox": f"0 0 {WIDTH:g} {HEIGHT:g}", "aria-hidden": "true"})
    for name, attributes in shapes:
        SubElement(svg, name, attributes)
    return ElementTree.tostring(svg, encoding="unicode")


ROW, AIR = 24.0, 0.9
"""Height of a row, [px]; space above the first and below the last one, in rows."""


def draw_split(name: str, split: Split) -> Chart | None:
    """The figure of an eta and both of its paths; None if no part has a value."""
    rows = split_rows(name, split)
    if not any(is_drawable(row.ratio) for row in rows[1:]):
        return None
    lowest = rows[-1].place + AIR
    names = [(-row.place, row.label.partition(",")[0]) for row in rows]
    names += [(-top, where) for where, top in PATHS if top < lowest]
    ratios = ratio_axis(name, rows)
    marks = [mark for row in rows for mark in (*draw_ratio(row, ratios), number_of(row))]
    places = Axis(-lowest, AIR, "", tuple(names), has_grid=False)
    return Chart(ratios, places, tuple(marks), height=ROW * (lowest + AIR))


def ratio_axis(name: str, rows: Iterable[SplitRow]) -> Axis:
    """A logarithmic axis for all that can be drawn of these rows of the eta of that name."""
    low, high = ratio_range([row.ratio for row in rows])
    side = better_of(name)
    called = f"; {side} is called better" if side != NEITHER else ""
    return Axis(low, high, f"ratio{called}", named_ticks(low, high), is_log=True)


def draw_ratio(row: SplitRow, axis: Axis) -> Iterator[Mark]:
    """The marks of a ratio: its interval, with the point on it. Empty if the axis has no place for it."""
    if not is_drawable(row.ratio) or row.ratio.value is None:
        return
    ends = interval_ends(row.ratio, axis.low, axis.high)
    if ends is not None:
        yield Line(list(ends), [-row.place] * 2, row.colour)
    told = f"{row.label}: {estimate_text(row.ratio)}"
    yield Dots([row.ratio.value], [-row.place], row.colour, (told,), row.shape, row.is_open, 4.5)


def number_of(row: SplitRow) -> Note:
    """The number and its interval at the right of the panel, or the word that stands in its place."""
    return Note(-row.place, estimate_text(row.ratio))
