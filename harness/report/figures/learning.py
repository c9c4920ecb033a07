"""Figures of what was learned: curves, performance profiles, ways to the target."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from harness.arrays import Float
from harness.eta.behaviour_change import Change, performance_profile
from harness.eta.headline import Text, count_seeds, percentage
from harness.report.figures.chart import GAP, Area, Axis, Chart, Dots, Line, Mark, Shape, linear_axis, share_axis
from harness.results.comparison import Comparison
from harness.results.learning import Learning, LearningCurve, Point
from harness.results.replay import Trajectories, Trajectory

STYLES: tuple[tuple[str, Shape], ...] = (("baseline", "circle"), ("proposed", "diamond"))
"""Colour and shape of the curves of either reward; one that stands alone looks as the proposed one."""
MOST = 8
"""Up to this many measures all are drawn; of more only the one that decides."""


def learning_names(learning: Learning, comparison: Comparison) -> list[str]:
    """What is drawn: the measure that decides first, then all others that are known under a reward.

    Of measures of an arm the one that decides alone: they are many.
    """
    known = [name for name in learning.random if learning.known(name)]
    first = [name for name in known if name in comparison.measured.deciding[:1]]
    measured = [change.name for change in comparison.measured.changes_of(comparison.manner)]
    if len(measured) > MOST:
        return [*first, *(name for name in known if name not in measured)]
    return [*first, *(name for name in known if name not in first)]


def learning_heading(name: str) -> str:
    """The heading of a panel."""
    return f"{name.replace('_', ' ').capitalize()} while learning"


def flat_text(learning: Learning, metric: str, text: Text = percentage) -> str:
    """The words in the place of a figure in which nothing happens; empty where something does."""
    points = learning.known(metric)
    values, steps = {point.mean.value for point in points}, [point.steps for point in points]
    if len(values) != 1 or len(set(steps)) < 2:
        return ""
    (value,) = values
    return (
        f"{learning_heading(metric)}: {text(value)} under both rewards at each of {len(set(steps))} evaluations, from "
        f"{min(steps):,} to {max(steps):,} steps."
    )


def draw_learning(learning: Learning, metric: str, text: Text = percentage) -> Chart:
    """Means as lines, intervals as bands, random actions as a dotted line.

    Args:
        learning: The learning under both rewards, or under one.
        metric: Which measure; a share, such as the success rate, unless `text` says otherwise.
        text: How its values are written: `percentage`, or as any other number.
    """
    curves, floor = learning.curves, learning.random.get(metric)
    last = max((point.steps for point in learning.known(metric)), default=1)
    bands, lines, dots = list[Area](), list[Line](), list[Dots]()
    for curve, (colour, shape) in zip(curves, STYLES[-len(curves) :], strict=True):
        known = curve.known(metric)
        bands.append(_band(curve.band(metric), colour))
        lines.append(Line(*_means(known), colour, curve.reward, width=2.5, in_legend=True))
        dots.append(_dots(known, colour, shape, text))
    if floor is not None:
        lines.append(Line([0, last], [floor, floor], "random", "random actions", dash="2 4", in_legend=True))
    steps = linear_axis(0.0, last, "environment step", 5)
    title = metric.replace("_", " ")
    values = share_axis(title) if text is percentage else _number_axis([*bands, *lines], title)
    return Chart(steps, values, (*bands, *lines, *dots))


def describe_learning(learning: Learning, metric: str, text: Text = percentage) -> str:
    """The same in words: where each curve begins and ends, and what a point is of."""
    curves, floor = learning.curves, learning.random.get(metric)
    told = [_told(curve, metric, text) for curve in curves]
    told += [] if floor is None else [f"random actions {text(floor)}"]
    return f"{'; '.join(told)}. Each point is of {' or '.join(dict.fromkeys(it.of for it in curves))}."


def _number_axis(marks: list[Area | Line], title: str) -> Axis:
    """An axis from the lowest to the highest value, with some margin."""
    values = [value for mark in marks for value in mark.y] or [0.0]
    air = 0.04 * (max(values) - min(values)) or 0.5
    return linear_axis(min(values) - air, max(values) + air, title)


def _told(curve: LearningCurve, metric: str, text: Text) -> str:
    points = curve.known(metric)
    if not points:
        return f"{curve.reward}: no value"
    ends = [f"{text(point.mean.value)} after {point.steps:,} steps" for point in (points[0], points[-1])]
    return f"{curve.reward} {', '.join(ends)}"


def _band(there: list[tuple[int, float, float]], colour: str) -> Area:
    """The band of intervals around the means; empty if there is only one seed."""
    back = there[::-1]
    ends = [*(high for _, _, high in there), *(low for _, low, _ in back)]
    return Area([steps for steps, _, _ in [*there, *back]], ends, colour)


def _dots(points: list[Point], colour: str, shape: Shape, text: Text) -> Dots:
    steps, means = _means(points)
    told = tuple(f"{text(mean)} after {step:,.0f} steps" for step, mean in zip(steps, means, strict=True))
    return Dots(steps, means, colour, told, shape, size=3.5)


def _means(points: list[Point]) -> tuple[list[float], list[float]]:
    known = [(float(point.steps), point.mean.value) for point in points if point.mean.value is not None]
    return [steps for steps, _ in known], [mean for _, mean in known]


LEVELS = 101


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
    at = np.linspace(0.0, 1.0, LEVELS)
    shares = performance_profile(values, at - 1e-9).round(4)
    x, y = np.repeat(at.round(3), 2)[1:].tolist(), np.repeat(shares, 2)[:-1].tolist()
    return Line(x, y, who, who, 2.5, dash=dash, in_legend=True)


def describe_profile(change: Change) -> str:
    """The same in words, for those who cannot see it."""
    worst = [min(values) for values in change.values]
    told = f"{worst[0]:.0%} under the baseline, {worst[1]:.0%} under the proposed reward"
    counts = " against ".join(map(count_seeds, dict.fromkeys(change.counts)))
    return f"{counts}. The worst seed: {told}."


PLACES = 30
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
    """At most `PLACES` points, evenly spaced, with the first and the last."""
    kept = np.linspace(0, len(points) - 1, min(len(points), PLACES)).round().astype(int)
    thinned: Float = points[kept]
    return thinned


def _axes(paths: Sequence[Trajectory]) -> list[Axis]:
    """The axes. A metre is equally long on all of them, so that directions and lengths look right."""
    points = np.concatenate([np.vstack([path.points, path.target]) for path in paths])
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = (low + high) / 2, 0.55 * float((high - low).max()) or 0.05
    named = zip(middle.tolist(), "xyz", strict=True)
    return [linear_axis(at - half, at + half, f"{axis} [m]", 5) for at, axis in named]
