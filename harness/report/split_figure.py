"""The figure of ruler x behaviour: an eta and its parts on a logarithmic axis, each with its interval."""

import math
from typing import Any, NamedTuple

from harness.decompose import Split
from harness.index import Ratio
from harness.report.figure import FONT, GRID, INK, Figure
from harness.report.rows import BETTER, interval_text, is_near_zero, ratio_text

GREY, GREEN = "#767676", "#009E73"
"""For ruler and behaviour; their rows are named too."""
FARTHEST = 1_000.0
"""An interval is drawn no farther than this factor beyond the outermost ratio."""
TICKS = ((0.45, (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 7, 8, 9)), (1.0, (1, 1.5, 2, 3, 5, 7)), (2.2, (1, 2, 5)))
"""Which digits are marked while the axis spans at most so many decades; beyond, powers of ten."""


class _Row(NamedTuple):
    label: str
    ratio: Ratio
    place: float
    colour: str
    symbol: str


def draw_split(name: str, split: Split) -> Figure | None:
    """An eta and both of its paths; None where no part has a value."""
    rows = [
        _Row(name, split.eta, 0.0, INK, "circle"),
        _Row("ruler", split.ruler, 1.3, GREY, "square"),
        _Row("behaviour", split.behaviour, 2.2, GREEN, "diamond"),
        _Row("ruler, other path", split.other_ruler, 3.5, GREY, "square-open"),
        _Row("behaviour, other path", split.other_behaviour, 4.4, GREEN, "diamond-open"),
    ]
    drawn = [row for row in rows if _is_drawable(row.ratio)]
    if not any(row.label != name for row in drawn):
        return None
    low, high = _range([row.ratio for row in drawn])
    layout = _layout(f"ratio; {BETTER[name]} is called better", rows, low, high)
    layout["annotations"] = [_missing(row) for row in rows if row not in drawn]
    return {"data": [_point(row, low, high) for row in drawn], "layout": layout}


def describe_split(name: str, split: Split) -> str:
    """The same in words."""
    first = f"ruler {ratio_text(split.ruler)} x behaviour {ratio_text(split.behaviour)}"
    other = f"ruler {ratio_text(split.other_ruler)} x behaviour {ratio_text(split.other_behaviour)}"
    return f"{name} {ratio_text(split.eta)} = {first}; other path: {other}."


def ticks(low: float, high: float) -> list[float]:
    """Round numbers between `low` and `high`, few enough to be read; 1 among them if it is there."""
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    decades = math.log10(high / low)
    digits = next((digits for most, digits in TICKS if decades <= most), None)
    if digits is None:
        step = math.ceil(decades / 6)
        values = [10.0**power for power in range(first, last + 1) if power % step == 0]
    else:
        values = [digit * 10.0**power for power in range(first, last + 1) for digit in digits]
    return [float(f"{value:.3g}") for value in values if low <= value <= high]


def _is_drawable(ratio: Ratio) -> bool:
    """A logarithm has no place for 0, and a ratio that says little would stretch the axis."""
    return ratio.value is not None and ratio.value > 0.0 and not is_near_zero(ratio)


def _range(ratios: list[Ratio]) -> tuple[float, float]:
    """What the axis spans: every ratio and interval, 1, and some air."""
    values = [ratio.value for ratio in ratios if ratio.value is not None]
    ends = [end for ratio in ratios for end in (ratio.low, ratio.high) if end is not None]
    low, high = min(0.85, *values), max(1.18, *values)
    low = min(low, *(max(end, low / FARTHEST) for end in ends)) if ends else low
    high = max(high, *(min(end, high * FARTHEST) for end in ends)) if ends else high
    air = (high / low) ** 0.08
    return low / air, high * air


def _point(row: _Row, low: float, high: float) -> Figure:
    value = row.ratio.value or 0.0
    error: Figure = {"visible": False}
    if row.ratio.low is not None and row.ratio.high is not None:
        ends = max(row.ratio.low, low), min(row.ratio.high, high)
        error = {
            "type": "data",
            "symmetric": False,
            "array": [max(0.0, ends[1] - value)],
            "arrayminus": [max(0.0, value - ends[0])],
            "color": row.colour,
            "thickness": 2,
            "width": 5,
        }
    return {
        "type": "scatter",
        "mode": "markers+text",
        "x": [value],
        "y": [row.place],
        "error_x": error,
        "text": [ratio_text(row.ratio)],
        "textposition": "top center",
        "textfont": {"size": 13, "color": INK},
        "cliponaxis": False,
        "marker": {"color": row.colour, "size": 11, "symbol": row.symbol, "line": {"color": row.colour, "width": 2}},
        "hovertemplate": f"{row.label}: {ratio_text(row.ratio)} {interval_text(row.ratio)}<extra></extra>",
    }


def _missing(row: _Row) -> Figure:
    """A word where a point would be."""
    return {
        "text": ratio_text(row.ratio),
        "x": 0.0,  # the logarithm of 1
        "y": row.place,
        "xanchor": "left",
        "xshift": 6,
        "showarrow": False,
        "font": {"size": 13, "color": INK},
    }


def _layout(title: str, rows: list[_Row], low: float, high: float) -> Figure:
    marks = ticks(low, high)
    reference: dict[str, Any] = {"type": "line", "x0": 1, "x1": 1, "yref": "paper", "y0": 0, "y1": 1, "layer": "below"}
    axis = {"showline": True, "linecolor": INK, "zeroline": False, "fixedrange": True, "automargin": True}
    return {
        "font": {"family": FONT, "size": 13, "color": INK},
        "paper_bgcolor": "#ffffff",
        "plot_bgcolor": "#ffffff",
        "height": 330,
        "margin": {"l": 10, "r": 24, "t": 10, "b": 10},
        "showlegend": False,
        "hovermode": "closest",
        "dragmode": False,
        "shapes": [{**reference, "line": {"color": INK, "width": 1.5}}],
        "xaxis": {
            **axis,
            "type": "log",
            "range": [math.log10(low), math.log10(high)],
            "tickvals": marks,
            "ticktext": [f"{mark:,g}" for mark in marks],
            "tickangle": 0,
            "ticks": "outside",
            "gridcolor": GRID,
            "title": {"text": title},
        },
        "yaxis": {
            **axis,
            "range": [4.9, -0.8],
            "tickvals": [row.place for row in rows],
            "ticktext": [row.label for row in rows],
            "showgrid": False,
        },
    }
