"""The figure of learning: a measure of behaviour over environment steps, under both rewards and by random actions."""

from typing import Any

from harness.report.figure import Figure
from harness.report.palette import BLUE, FONT, GREY, GRID, INK, VERMILION, faint
from harness.results.learning import Learning, LearningCurve, Point


def draw_learning(learning: Learning, metric: str) -> Figure:
    """A share such as the success rate: means as lines, intervals as bands, random actions as a dotted line."""
    curves = ((learning.baseline, BLUE, "circle"), (learning.proposed, VERMILION, "diamond"))
    known = [(curve, curve.known(metric), colour, symbol) for curve, colour, symbol in curves]
    data = [_band(curve.band(metric), colour) for curve, colour, _ in curves]
    data += [_line(curve.reward, points, colour, symbol) for curve, points, colour, symbol in known]
    last = learning.last_step(metric)
    floor = learning.random[metric]
    if floor is not None:
        data.append(_floor(floor, last))
    return {"data": data, "layout": _layout(metric.replace("_", " "), last)}


def describe_learning(learning: Learning, metric: str) -> str:
    """The same in words: where each curve begins and ends."""
    told = [_told(curve, metric) for curve in (learning.baseline, learning.proposed)]
    floor = learning.random[metric]
    return "; ".join([*told, *([f"random actions {floor:.1%}"] if floor is not None else [])]) + "."


def _told(curve: LearningCurve, metric: str) -> str:
    points = curve.known(metric)
    if not points:
        return f"{curve.reward}: no value"
    ends = [f"{point.value.mean:.1%} after {point.steps:,} steps" for point in (points[0], points[-1])]
    return f"{curve.reward} {', '.join(ends)}"


def _band(there: list[tuple[int, float, float]], colour: str) -> Figure:
    """Around the means, there and back; empty of a single seed."""
    back = there[::-1]
    return {
        "type": "scatter",
        "mode": "lines",
        "x": [steps for steps, _, _ in [*there, *back]],
        "y": [*(high for _, _, high in there), *(low for _, low, _ in back)],
        "fill": "toself",
        "fillcolor": faint(colour),
        "line": {"width": 0, "color": colour},
        "hoverinfo": "skip",
        "showlegend": False,
    }


def _line(reward: str, points: list[Point], colour: str, symbol: str) -> Figure:
    return {
        "type": "scatter",
        "mode": "lines+markers",
        "name": reward,
        "x": [point.steps for point in points],
        "y": [point.value.mean for point in points],
        "line": {"color": colour, "width": 2.5},
        "marker": {"color": colour, "size": 7, "symbol": symbol},
        "cliponaxis": False,
        "hovertemplate": f"{reward}: %{{y:.1%}} after %{{x:,}} steps<extra></extra>",
    }


def _floor(share: float, last: int) -> Figure:
    return {
        "type": "scatter",
        "mode": "lines",
        "name": "random actions",
        "x": [0, last],
        "y": [share, share],
        "line": {"color": GREY, "width": 2, "dash": "dot"},
        "hovertemplate": "random actions: %{y:.1%}<extra></extra>",
    }


def _layout(title: str, last: int) -> Figure:
    axis: dict[str, Any] = {
        "showline": True,
        "linecolor": INK,
        "gridcolor": GRID,
        "ticks": "outside",
        "automargin": True,
        "zeroline": False,
    }
    return {
        "font": {"family": FONT, "size": 13, "color": INK},
        "paper_bgcolor": "#ffffff",
        "plot_bgcolor": "#ffffff",
        "height": 390,
        "margin": {"l": 10, "r": 24, "t": 68, "b": 10},  # room for the legend below the buttons
        "showlegend": True,
        "legend": {"orientation": "h", "x": 0, "y": 1.02, "yanchor": "bottom"},
        "hovermode": "closest",
        "dragmode": False,  # a finger on the figure scrolls the page
        "xaxis": {
            **axis,
            "range": [0, last],
            "title": {"text": "environment step"},
            "tickformat": ",d",
            "tickangle": 0,
            "nticks": 6,
        },
        "yaxis": {**axis, "range": [-0.02, 1.02], "title": {"text": title}, "tickformat": ".0%", "fixedrange": True},
    }
