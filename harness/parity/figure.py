"""The figures of a parity: how far apart tips and joints are over time, a line per pair.

Figures are plain data in plotly's JSON schema, as those of the report.
"""

import math

from harness.arrays import Float
from harness.parity.grids import pair_name, reference_pairs
from harness.parity.parity import Pair, Parity
from harness.report.figure import Figure
from harness.report.palette import FONT, GRID, INK
from harness.report.points import select_points

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#1a1a1a")
"""Apart for every kind of colour vision (Okabe and Ito)."""
DASHES = ("solid", "dash", "dot", "dashdot", "longdash")
"""Lines of pairs may cover one another: each has its own dashes as well. Their number and the colours' share no
factor, so that all 35 combinations come."""

LEGEND_LINE = 20
"""Height, [px]."""


def draw_tips(parity: Parity) -> Figure:
    """The distance of the tips at each time, the largest over all motions, [mm]."""
    return _draw(parity, "max_tip_error_m", 1e3, "distance of the tips [mm]", "mm")


def draw_joints(parity: Parity) -> Figure:
    """The same of the joint that is farthest off, [deg]."""
    return _draw(parity, "max_joint_error_rad", math.degrees(1.0), "difference of a joint [deg]", "deg")


def _draw(parity: Parity, curve: str, factor: float, label: str, unit: str) -> Figure:
    """What is not measured from the reference is in the legend alone until it is clicked; without any, all is shown."""
    shown = reference_pairs(parity) or parity.pairs
    lines = [
        {
            **_line(number, pair, parity.setting.period, factor * pair.drift.curves()[curve], unit),
            "visible": True if pair in shown else "legendonly",
        }
        for number, pair in enumerate(parity.pairs)
    ]
    return {"data": lines, "layout": _layout(label, len(lines))}


def _line(number: int, pair: Pair, period: float, values: Float, unit: str) -> Figure:
    points = select_points(values)
    return {
        "type": "scatter",
        "mode": "lines",
        "name": pair_name(pair),
        "x": [float(f"{time:.6g}") for time in (points * period).tolist()],
        "y": [float(f"{value:.6g}") for value in values[points].tolist()],
        "line": {"color": COLOURS[number % len(COLOURS)], "dash": DASHES[number % len(DASHES)], "width": 2},
        "hovertemplate": f"{pair_name(pair)}: %{{y:.3~g}} {unit} at %{{x:g}} s<extra></extra>",
    }


def _layout(label: str, lines: int) -> Figure:
    axis = {"showline": True, "linecolor": INK, "gridcolor": GRID, "ticks": "outside", "automargin": True}
    return {
        "font": {"family": FONT, "size": 13, "color": INK},
        "paper_bgcolor": "#ffffff",
        "plot_bgcolor": "#ffffff",
        "height": 340 + LEGEND_LINE * lines,
        "margin": {"l": 10, "r": 24, "t": 44, "b": 60 + LEGEND_LINE * lines},
        "showlegend": True,
        "legend": {
            "orientation": "h",
            "yref": "container",
            "y": 0,
            "yanchor": "bottom",
            "entrywidth": 1,
            "entrywidthmode": "fraction",
        },
        "hovermode": "closest",
        "dragmode": False,  # a finger on the panel scrolls the page
        "updatemenus": [_scale_buttons()],
        "xaxis": {**axis, "title": {"text": "time [s]"}, "zeroline": False},
        "yaxis": {**axis, "title": {"text": label}, "rangemode": "tozero", "exponentformat": "power"},
    }


def _scale_buttons() -> Figure:
    """Linear first: a pair without any difference has no place on a logarithmic axis."""
    buttons = [
        {"label": f"{scale} axis", "method": "relayout", "args": [{"yaxis.type": scale, "yaxis.autorange": True}]}
        for scale in ("linear", "log")
    ]
    place = {"x": 0, "xanchor": "left", "y": 1, "yanchor": "bottom", "pad": {"b": 6}}
    return {"type": "buttons", "direction": "right", "showactive": True, "buttons": buttons, **place}
