"""The figure of ruler x behaviour: an eta and its parts on a logarithmic axis, each with its interval."""

import math
from typing import Any

from harness.eta.decompose import Split
from harness.report.figure import Figure
from harness.report.palette import FONT, GRID, INK
from harness.report.ratio_axis import interval_ends, is_drawable, ratio_range, ticks
from harness.report.rows import BETTER, interval_text, ratio_text
from harness.report.split_rows import SplitRow, has_parts, split_rows


def draw_split(name: str, split: Split) -> Figure | None:
    """An eta and both of its paths; None where no part has a value."""
    rows = split_rows(name, split)
    if not has_parts(rows):
        return None
    drawn = [row for row in rows if is_drawable(row.ratio)]
    low, high = ratio_range([row.ratio for row in drawn])
    layout = _layout(f"ratio; {BETTER[name]} is called better", rows, low, high)
    layout["annotations"] = [_missing(row) for row in rows if row not in drawn]
    return {"data": [_point(row, low, high) for row in drawn], "layout": layout}


def _point(row: SplitRow, low: float, high: float) -> Figure:
    value = row.ratio.value or 0.0
    error: Figure = {"visible": False}
    ends = interval_ends(row.ratio, low, high)
    if ends is not None:
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


def _missing(row: SplitRow) -> Figure:
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


def _layout(title: str, rows: list[SplitRow], low: float, high: float) -> Figure:
    marks = ticks(low, high)
    reference: dict[str, Any] = {"type": "line", "x0": 1, "x1": 1, "yref": "paper", "y0": 0, "y1": 1, "layer": "below"}
    axis = {"showline": True, "linecolor": INK, "zeroline": False, "fixedrange": True, "automargin": True}
    return {
        "font": {"family": FONT, "size": 13, "color": INK},
        "paper_bgcolor": "#ffffff",
        "plot_bgcolor": "#ffffff",
        "height": 400,
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
            "range": [7.1, -0.8],
            "tickvals": [row.place for row in rows],
            "ticktext": [row.label for row in rows],
            "showgrid": False,
        },
    }
