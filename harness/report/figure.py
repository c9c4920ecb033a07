"""The figure of the published experiment: the accumulated reward of every run, and their mean, per reward.

Figures are plain data in plotly's JSON schema, so that drawing needs nothing but plotly.js in the reader's browser.
"""

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from harness.combination import Combination
from harness.curve import GroupCurve
from harness.decompose import BB, KK
from harness.index import Index

Float = NDArray[np.float64]
Figure: TypeAlias = dict[str, Any]

POINTS = 1_000
"""Points drawn per curve, at most: more than a panel has pixels; every step of every run would make 100 MB pages."""

BLUE, VERMILION = "#0072B2", "#D55E00"
"""For baseline and proposed; apart for every kind of colour vision (Okabe and Ito), and in grey."""
INK, GRID = "#1a1a1a", "#e3e3e3"
FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"


def draw_panels(combination: Combination) -> tuple[Figure, Figure] | None:
    """A panel for the baseline and one for the proposed reward, on equal axes; None without a finished pair.

    Two figures, not one: a narrow screen stacks them.
    """
    baseline, proposed = combination.baseline_index, combination.proposed_index
    if baseline is None or proposed is None:
        return None
    curves = (combination.curves[BB], combination.curves[KK])
    ranges = {"x": _step_range(*curves), "y": _reward_range(*curves)}
    return (
        _draw_panel(curves[0], combination.seeds, baseline, BLUE, ranges),
        _draw_panel(curves[1], combination.seeds, proposed, VERMILION, ranges),
    )


def select_points(values: Float, points: int = POINTS) -> NDArray[np.int64]:
    """Which steps to draw: the first, the last, and the extremes of each stretch between, in order, (<= points,).

    Every stretch keeps its lowest and its highest value, so the drawn curve reaches as far as the real one and crosses
    zero in the same stretches. Averages or every n-th step would not.
    """
    count = len(values)
    if count <= points:
        return np.arange(count)
    stretches = np.array_split(np.arange(count), points // 2 - 1)
    extremes = [stretch[pick(values[stretch])] for stretch in stretches for pick in (np.argmin, np.argmax)]
    return np.unique([0, *extremes, count - 1])


def _draw_panel(
    curve: GroupCurve, seeds: tuple[int, ...], index: Index, colour: str, ranges: dict[str, list[float]]
) -> Figure:
    runs, stride = curve.runs, curve.stride
    mean = runs.mean(axis=0)
    thin = [
        _curve(run, stride, f"seed {seed}", {"color": colour, "width": 1}, opacity=0.45)
        for run, seed in zip(runs, seeds, strict=True)
    ]
    thick = _curve(mean, stride, "mean", {"color": colour, "width": 3.5})
    steps = {"first negative": index.first_negative, "cross-over": index.crossover}
    marked = {name: step for name, step in steps.items() if step is not None}
    layout = _layout(ranges)
    layout["shapes"] = [_vertical_line(step) for step in marked.values()]
    layout["annotations"] = [_label(name, step, ranges["x"][1]) for name, step in marked.items()]
    return {"data": [*thin, thick, _markers(marked, mean, stride, colour)], "layout": layout}


def _curve(values: Float, stride: int, name: str, line: dict[str, Any], opacity: float = 1.0) -> Figure:
    """A line through every `stride`-th step's value."""
    points = select_points(values)
    return {
        "type": "scatter",
        "mode": "lines",
        "name": name,
        "x": (points * stride).tolist(),
        "y": [_plain(value) for value in values[points].tolist()],
        "line": line,
        "opacity": opacity,
        "hovertemplate": f"{name}: %{{y:,.4~g}} at step %{{x:,}}<extra></extra>",
    }


def _markers(marked: dict[str, int], mean: Float, stride: int, colour: str) -> Figure:
    """A dot on the drawn mean curve at each marked step."""
    heights = np.interp(list(marked.values()), np.arange(len(mean)) * stride, mean)
    return {
        "type": "scatter",
        "mode": "markers",
        "x": list(marked.values()),
        "y": [_plain(height) for height in heights.tolist()],
        "text": list(marked),
        "cliponaxis": False,
        "marker": {"color": "#ffffff", "size": 9, "line": {"color": colour, "width": 2.5}},
        "hovertemplate": "%{text}: step %{x:,}<extra></extra>",
    }


def _vertical_line(step: int) -> Figure:
    return {
        "type": "line",
        "xref": "x",
        "yref": "paper",
        "x0": step,
        "x1": step,
        "y0": 0,
        "y1": 1,
        "layer": "below",
        "line": {"color": INK, "width": 1, "dash": "dot"},
    }


def _label(name: str, step: int, last: float) -> Figure:
    """A line of text above the panel, where no curve can cover it; each name has a line of its own."""
    return {
        "text": f"{name}: step {step:,}",
        "xref": "x",
        "yref": "paper",
        "x": step,
        "y": 1,
        "yanchor": "bottom",
        "yshift": 18 if name == "first negative" else 1,
        "xanchor": "left" if step < last / 2 else "right",
        "showarrow": False,
        "font": {"size": 13, "color": INK},
    }


def _layout(ranges: dict[str, list[float]]) -> Figure:
    axis = {"showline": True, "linecolor": INK, "gridcolor": GRID, "ticks": "outside", "separatethousands": True}
    return {
        "font": {"family": FONT, "size": 13, "color": INK},
        "paper_bgcolor": "#ffffff",
        "plot_bgcolor": "#ffffff",
        "height": 360,
        "margin": {"l": 10, "r": 24, "t": 44, "b": 10},
        "showlegend": False,
        "hovermode": "closest",
        "dragmode": False,  # a finger on the panel scrolls the page
        "xaxis": {
            **axis,
            "range": ranges["x"],
            "title": {"text": "environment step"},
            "zeroline": False,
            "tickformat": ",d",
            "tickangle": 0,
            "nticks": 5,
            "automargin": True,
        },
        "yaxis": {
            **axis,
            "range": ranges["y"],
            "title": {"text": "accumulated shaped reward"},
            "zerolinecolor": "#767676",
            "fixedrange": True,  # zooming into one panel must not unequal the two
            "exponentformat": "none",
            "automargin": True,
        },
    }


def _step_range(*curves: GroupCurve) -> list[float]:
    return [0, max(curve.index.steps for curve in curves) - 1]


def _reward_range(*curves: GroupCurve) -> list[float]:
    """From the lowest to the highest value of both groups, zero always in it, with some air."""
    low = min(0.0, *(float(curve.runs.min()) for curve in curves))
    high = max(0.0, *(float(curve.runs.max()) for curve in curves))
    air = 0.04 * (high - low) or 1.0
    return [low - air, high + air]


def _plain(value: float) -> float:
    """Six significant digits, which no eye can tell from more."""
    return float(f"{value:.6g}")
