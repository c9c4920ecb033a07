"""The performance profile: which share of the seeds reaches at least so much, under both rewards."""

import numpy as np

from harness.eta.aggregate import performance_profile
from harness.eta.behaviour_change import Change
from harness.eta.headline import count_seeds
from harness.report.figure import Figure
from harness.report.palette import BLUE, FONT, GRID, INK, VERMILION

POINTS = 101


def draw_profile(change: Change) -> Figure | None:
    """Both profiles of a share such as the success rate, as steps; None without a seed."""
    if not change.values:
        return None
    at = np.linspace(0.0, 1.0, POINTS)
    lines = (("baseline", 0, BLUE, "solid"), ("proposed", 1, VERMILION, "dash"))
    data = [
        {
            "type": "scatter",
            "mode": "lines",
            "name": who,
            "x": at.round(3).tolist(),
            "y": performance_profile([pair[side] for pair in change.values], at - 1e-9).round(4).tolist(),
            "line": {"color": colour, "width": 3, "dash": dash, "shape": "hv"},
            "hovertemplate": f"{who}: %{{y:.0%}} of the seeds reach at least %{{x:.0%}}<extra></extra>",
        }
        for who, side, colour, dash in lines
    ]
    return {"data": data, "layout": _layout(change.name.replace("_", " "))}


def describe_profile(change: Change) -> str:
    """The same in words, for those who cannot see it."""
    worst = [min(pair[side] for pair in change.values) for side in (0, 1)]
    told = f"{worst[0]:.0%} under the baseline, {worst[1]:.0%} under the proposed reward"
    return f"{count_seeds(change.seeds)}. The worst seed: {told}."


def _layout(name: str) -> Figure:
    axis = {"showline": True, "linecolor": INK, "gridcolor": GRID, "ticks": "outside", "tickformat": ".0%"}
    return {
        "font": {"family": FONT, "size": 13, "color": INK},
        "paper_bgcolor": "#ffffff",
        "plot_bgcolor": "#ffffff",
        "height": 300,
        "margin": {"l": 10, "r": 24, "t": 10, "b": 10},
        "legend": {"x": 0.02, "y": 0.05},
        "hovermode": "closest",
        "dragmode": False,
        "xaxis": {**axis, "range": [0, 1.01], "title": {"text": f"{name} of a seed, at least"}, "automargin": True},
        "yaxis": {**axis, "range": [0, 1.05], "title": {"text": "share of the seeds"}, "automargin": True},
    }
