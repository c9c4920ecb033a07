"""The figure of the end effector's paths, as NOTE Fig. 7: from each start to its target, in two projections."""

from collections.abc import Iterable, Sequence
from typing import Any, TypeAlias

import numpy as np

from harness.arrays import Float
from harness.report.figure import Figure
from harness.report.palette import BLUE, FONT, GREY, GRID, INK, VERMILION
from harness.results.trajectories import Trajectories, Trajectory

POINTS = 60
"""Of one path, at most: an episode of thousands of steps is drawn every so many."""
VIEWS = (("x", "y", 0, 1, "seen from above"), ("x2", "y2", 0, 2, "seen from the side"))
"""The two projections: plotly's names of the axes, which coordinates are drawn, and what it is called."""

Spot: TypeAlias = tuple[float | None, float | None]
"""In a projection; (None, None) between one path and the next of the same line."""


def draw_trajectories(trajectories: Trajectories) -> tuple[Figure, Figure]:
    """The baseline's paths and the proposed reward's, on equal axes."""
    layout = _layout([*trajectories.baseline, *trajectories.proposed])
    sides = ((trajectories.baseline, BLUE), (trajectories.proposed, VERMILION))
    baseline, proposed = ({"data": _draw(paths, colour), "layout": layout} for paths, colour in sides)
    return baseline, proposed


def describe_trajectories(seed: int, paths: Sequence[Trajectory]) -> str:
    """The same in words: whose paths these are, and how many reach the target."""
    reached = sum(path.reached for path in paths)
    return f"Seed {seed}: {reached} of the first {len(paths)} evaluation episodes reach the target."


def _draw(paths: Sequence[Trajectory], colour: str) -> list[Figure]:
    """Both projections; the legend names each kind of line and point once."""
    reached, missed = ([path for path in paths if path.reached is wanted] for wanted in (True, False))
    line = {"color": colour, "width": 1.5}
    data = []
    for x, y, across, up, _ in VIEWS:
        place = {"xaxis": x, "yaxis": y, "showlegend": x == "x"}
        columns = [across, up]
        kinds = (
            ("missed", _lines(missed, columns), {"mode": "lines", "line": {**line, "color": GREY, "dash": "dot"}}),
            ("reached", _lines(reached, columns), {"mode": "lines", "line": line}),
            ("missed: its end", _spots([path.points[-1] for path in missed], columns), _marker("x-thin", GREY, 7)),
            ("start", _spots([path.points[0] for path in paths], columns), _marker("circle", INK, 4)),
            ("target", _spots([path.target for path in paths], columns), _marker("diamond-open", INK, 6)),
        )
        data += [_trace(name, points, {**look, **place}) for name, points, look in kinds if points]
    return data


def _trace(name: str, points: list[Spot], look: dict[str, Any]) -> Figure:
    across, up = zip(*points, strict=True)
    return {
        "type": "scatter",
        "name": name,
        "legendgroup": name,
        "x": list(across),
        "y": list(up),
        "hoverinfo": "skip",
        **look,
    }


def _marker(symbol: str, colour: str, size: int) -> dict[str, Any]:
    return {
        "mode": "markers",
        "marker": {"symbol": symbol, "color": colour, "size": size, "line": {"color": colour, "width": 1.5}},
    }


def _lines(paths: Iterable[Trajectory], columns: list[int]) -> list[Spot]:
    """All paths as one line with gaps."""
    line: list[Spot] = []
    for path in paths:
        line += [*_spots(_thinned(path.points), columns), (None, None)]
    return line[:-1]


def _spots(points: Iterable[Float], columns: list[int]) -> list[Spot]:
    return [(_plain(point[columns[0]]), _plain(point[columns[1]])) for point in points]


def _thinned(points: Float) -> Float:
    """At most `POINTS` of them, evenly, the first and the last among them."""
    kept = np.linspace(0, len(points) - 1, min(len(points), POINTS)).round().astype(int)
    thinned: Float = points[kept]
    return thinned


def _plain(value: float) -> float:
    """Four significant digits."""
    return float(f"{value:.4g}")


def _layout(paths: Sequence[Trajectory]) -> Figure:
    """Metres are equally long on all axes, so that a straight path looks straight and as long as it is."""
    points = np.concatenate([np.vstack([path.points, path.target]) for path in paths])
    axis: dict[str, Any] = {
        "showline": True,
        "linecolor": INK,
        "gridcolor": GRID,
        "zeroline": False,
        "fixedrange": True,
        "nticks": 5,
        "constrain": "domain",
    }
    layout: Figure = {
        "font": {"family": FONT, "size": 13, "color": INK},
        "paper_bgcolor": "#ffffff",
        "plot_bgcolor": "#ffffff",
        "height": 400,
        "margin": {"l": 55, "r": 10, "t": 70, "b": 45},
        "legend": {"orientation": "h", "x": 0, "y": 1.1, "yanchor": "bottom", "font": {"size": 12}},
        "hovermode": False,
        "dragmode": False,
        "annotations": [],
    }
    for place, (x, y, across, up, name) in enumerate(VIEWS):
        layout[_axis_key(x)] = {
            **axis,
            "anchor": y,
            "domain": [0.57 * place, 0.43 + 0.57 * place],
            "range": _range(points[:, across]),
            "title": {"text": f"{'xyz'[across]} [m]"},
        }
        layout[_axis_key(y)] = {
            **axis,
            "anchor": x,
            "scaleanchor": x,
            "range": _range(points[:, up]),
            "title": {"text": f"{'xyz'[up]} [m]"},
        }
        layout["annotations"].append(_heading(name, x, y))
    return layout


def _axis_key(name: str) -> str:
    """How a layout calls the axis that a trace calls `name`."""
    return f"{name[0]}axis{name[1:]}"


def _heading(text: str, x: str, y: str) -> Figure:
    """Above a projection."""
    return {
        "text": text,
        "xref": f"{x} domain",
        "yref": f"{y} domain",
        "x": 0,
        "y": 1,
        "xanchor": "left",
        "yanchor": "bottom",
        "showarrow": False,
        "font": {"size": 13, "color": INK},
    }


def _range(values: Float) -> list[float]:
    """All of them, with some air."""
    low, high = float(values.min()), float(values.max())
    air = 0.05 * (high - low) or 0.05
    return [_plain(low - air), _plain(high + air)]
