"""The performance profile: which share of the seeds reaches at least so much, under both rewards."""

from collections.abc import Sequence

import numpy as np

from harness.eta.behaviour_change import Change, performance_profile
from harness.eta.headline import count_seeds
from harness.report.figures.chart import Chart, Line, share_axis

POINTS = 101


def draw_profile(change: Change) -> Chart:
    """Both profiles of a share such as the success rate, as steps; of at least a seed of each reward."""
    lines = (("baseline", 0, ""), ("proposed", 1, "7 4"))
    name = change.name.replace("_", " ")
    return Chart(
        share_axis(f"{name} of a seed, at least"),
        share_axis("share of the seeds"),
        tuple(_steps(change.values[side], who, dash) for who, side, dash in lines),
    )


def _steps(values: Sequence[float], who: str, dash: str) -> Line:
    """A line that is level from one place to the next, and falls there."""
    at = np.linspace(0.0, 1.0, POINTS)
    shares = performance_profile(values, at - 1e-9).round(4)
    x, y = np.repeat(at.round(3), 2)[1:].tolist(), np.repeat(shares, 2)[:-1].tolist()
    return Line(x, y, who, who, 2.5, dash=dash, in_legend=True)


def describe_profile(change: Change) -> str:
    """The same in words, for those who cannot see it."""
    worst = [min(values) for values in change.values]
    told = f"{worst[0]:.0%} under the baseline, {worst[1]:.0%} under the proposed reward"
    counts = " against ".join(map(count_seeds, dict.fromkeys(change.counts)))
    return f"{counts}. The worst seed: {told}."
