"""The figure of the published experiment: the accumulated reward of every run, and their mean, per reward.

Figures are plain data in plotly's JSON schema, so that drawing needs nothing but plotly.js in the reader's browser.
"""

from typing import Any, TypeAlias

from harness.arrays import Float
from harness.report.palette import FONT, GRID, INK, faint
from harness.report.panel import Panel, panels_of, reward_range, step_range
from harness.report.points import POINTS, select_points
from harness.report.regions import Region, regions_of
from harness.results.combination import Combination

Figure: TypeAlias = dict[str, Any]


def draw_panels(combination: Combination, points: int = POINTS) -> tuple[Figure, Figure] | None:
    """A panel for the baseline and one for the proposed reward, on equal axes; None without a finished pair.

    Two figures, not one: a narrow screen stacks them.

    Args:
        combination: What to draw.
        points: Of a single run, at most.
    """
    panels = panels_of(combination)
    if panels is None:
        return None
    ranges = {"x": list(step_range(panels)), "y": list(reward_range(panels))}
    return _draw_panel(panels[0], ranges, points), _draw_panel(panels[1], ranges, points)


def _draw_panel(panel: Panel, ranges: dict[str, list[float]], points: int) -> Figure:
    stride, colour = panel.stride, panel.colour
    thin = [
        draw_curve(run, stride, f"seed {seed}", {"color": colour, "width": 1}, 0.45, points)
        for run, seed in zip(panel.runs, panel.seeds, strict=True)
    ]
    regions = regions_of(panel)
    shades = [_shade(region, colour) for region in regions]
    thick = draw_curve(panel.mean, stride, "mean", {"color": colour, "width": 3.5})
    layout = _layout(ranges)
    layout["shapes"] = [_vertical_line(step) for step in panel.marks.values()]
    layout["annotations"] = [_label(name, step, ranges["x"][1]) for name, step in panel.marks.items()]
    layout["annotations"] += [_name(region) for region in regions if region.has_room(ranges["x"][1])]
    return {"data": [*shades, *thin, thick, _markers(panel)], "layout": layout}


def draw_curve(
    values: Float, stride: int, name: str, line: dict[str, Any], opacity: float = 1.0, most: int = POINTS
) -> Figure:
    """A line through every `stride`-th step's value, of which `most` are drawn."""
    points = select_points(values, most)
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


def _shade(region: Region, colour: str) -> Figure:
    """The area of a region, under the curves."""
    return {
        "type": "scatter",
        "mode": "none",
        "name": region.name,
        "x": [_plain(step) for step in region.x.tolist()],
        "y": [_plain(value) for value in region.y.tolist()],
        "fill": "tozeroy",
        "fillcolor": faint(colour),
        "hoverinfo": "skip",
    }


def _name(region: Region) -> Figure:
    """A region's name inside it, readable on the curves too."""
    x, y = region.centre
    return {
        "text": region.name,
        "x": x,
        "y": y,
        "showarrow": False,
        "bgcolor": "rgba(255, 255, 255, 0.75)",
        "borderpad": 1,
        "font": {"size": 15, "color": INK},
    }


def _markers(panel: Panel) -> Figure:
    """A dot on the drawn mean curve at each marked step."""
    return {
        "type": "scatter",
        "mode": "markers",
        "x": list(panel.marks.values()),
        "y": [_plain(height) for height in panel.heights],
        "text": list(panel.marks),
        "cliponaxis": False,
        "marker": {"color": "#ffffff", "size": 9, "line": {"color": panel.colour, "width": 2.5}},
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


def _plain(value: float) -> float:
    """Six significant digits, which no eye can tell from more."""
    return float(f"{value:.6g}")
