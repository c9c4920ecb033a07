"""The figure of the end effector's paths, as NOTE Fig. 7: from each start to its target, in two projections."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from harness.arrays import Float
from harness.report.figures.chart import GAP, Axis, Chart, Dots, Line, Mark, linear_axis
from harness.results.trajectories import Trajectories, Trajectory

POINTS = 30
"""The most points of one path. Of an episode with thousands of steps, only some steps are drawn."""
VIEWS = ((0, 1, "seen from above"), (0, 2, "seen from the side"))
"""The two projections: which coordinates are drawn, and what it is called."""


def draw_trajectories(trajectories: Trajectories) -> tuple[tuple[Chart, ...], tuple[Chart, ...]]:
    """The baseline's paths and the proposed reward's, a chart for each projection, on equal axes."""
    axes = _axes([*trajectories.baseline, *trajectories.proposed])
    sides = ((trajectories.baseline, "baseline"), (trajectories.proposed, "proposed"))
    baseline, proposed = (
        tuple(
            Chart(axes[across], axes[up], tuple(_marks(paths, [across, up], colour)), is_square=True)
            for across, up, _ in VIEWS
        )
        for paths, colour in sides
    )
    return baseline, proposed


def describe_trajectories(seed: int, paths: Sequence[Trajectory]) -> str:
    """The same in words: whose paths these are, and how many reach the target."""
    reached = sum(path.reached for path in paths)
    return f"Seed {seed}: {reached} of the first {len(paths)} evaluation episodes reach the target."


def _marks(paths: Sequence[Trajectory], columns: list[int], colour: str) -> Iterator[Mark]:
    """The marks of the paths. Marks that do not occur are left out of the legend."""
    reached, missed = ([path for path in paths if path.reached is wanted] for wanted in (True, False))
    if missed:
        yield Line(*_lines(missed, columns), "random", "missed", 1.5, dash="2 3", in_legend=True)
    if reached:
        yield Line(*_lines(reached, columns), colour, "reached", 1.5, in_legend=True)
    ends = [path.points[-1] for path in missed]
    if missed:
        yield Dots(*_spots(ends, columns), "random", shape="cross", size=3.0, legend="missed: its end")
    if paths:
        yield Dots(*_spots([path.points[0] for path in paths], columns), "ink", size=2.5, legend="start")
        targets = [path.target for path in paths]
        yield Dots(*_spots(targets, columns), "ink", shape="diamond", is_open=True, size=3.0, legend="target")


def _lines(paths: Iterable[Trajectory], columns: list[int]) -> tuple[list[float], list[float]]:
    """All paths as one line with gaps."""
    across: list[float] = []
    up: list[float] = []
    for path in paths:
        x, y = _spots(_thinned(path.points), columns)
        across += [*x, GAP]
        up += [*y, GAP]
    return across, up


def _spots(points: Iterable[Float], columns: list[int]) -> tuple[list[float], list[float]]:
    spots = np.stack(list(points))[:, columns]
    return spots[:, 0].tolist(), spots[:, 1].tolist()


def _thinned(points: Float) -> Float:
    """At most `POINTS` points, evenly spaced, with the first and the last."""
    kept = np.linspace(0, len(points) - 1, min(len(points), POINTS)).round().astype(int)
    thinned: Float = points[kept]
    return thinned


def _axes(paths: Sequence[Trajectory]) -> list[Axis]:
    """The axes. A metre is equally long on all of them, so that directions and lengths look right."""
    points = np.concatenate([np.vstack([path.points, path.target]) for path in paths])
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = (low + high) / 2, 0.55 * float((high - low).max()) or 0.05
    named = zip(middle.tolist(), "xyz", strict=True)
    return [linear_axis(at - half, at + half, f"{axis} [m]", 5) for at, axis in named]
