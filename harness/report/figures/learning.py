"""The figure of learning: a measure of behaviour over environment steps, under both rewards and by random actions."""

from collections.abc import Sequence

from harness.report.figures.chart import Area, Axis, Chart, Dots, Line, Shape, linear_axis, share_axis
from harness.report.rows.behaviour import percentage
from harness.report.rows.ratios import Text
from harness.results.comparison import Comparison
from harness.results.learning import Learning, LearningCurve, Point

STYLES: tuple[tuple[str, Shape], ...] = (("baseline", "circle"), ("proposed", "diamond"))
"""Colour and shape of the curves of either reward; one that stands alone looks as the proposed one."""
MOST = 8
"""Up to this many measures all are drawn; of more only the one that decides."""


def learning_names(learning: Learning, comparison: Comparison) -> list[str]:
    """What is drawn: the measure that decides first, then all others that are known under a reward.

    Of measures of an arm the one that decides alone: they are many.
    """
    known = [name for name in learning.random if learning.baseline.known(name) or learning.proposed.known(name)]
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
    points = [*learning.baseline.known(metric), *learning.proposed.known(metric)]
    values, steps = {point.value.mean for point in points}, [point.steps for point in points]
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
        learning: The learning under both rewards.
        metric: Which measure; a share, such as the success rate, unless `text` says otherwise.
        text: How its values are written: `percentage`, or as any other number.
    """
    return draw_curves((learning.baseline, learning.proposed), learning.random[metric], metric, text)


def draw_curves(curves: Sequence[LearningCurve], floor: float | None, metric: str, text: Text) -> Chart:
    """The same of one reward or two, and of what random actions come to."""
    last = max((point.steps for curve in curves for point in curve.known(metric)), default=1)
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
    """The same in words: where each curve begins and ends."""
    return describe_curves((learning.baseline, learning.proposed), learning.random[metric], metric, text)


def describe_curves(curves: Sequence[LearningCurve], floor: float | None, metric: str, text: Text) -> str:
    """The same of one reward or two."""
    told = [_told(curve, metric, text) for curve in curves]
    return "; ".join([*told, *([] if floor is None else [f"random actions {text(floor)}"])]) + "."


def _number_axis(marks: list[Area | Line], title: str) -> Axis:
    """An axis from the lowest to the highest value, with some margin."""
    values = [value for mark in marks for value in mark.y] or [0.0]
    air = 0.04 * (max(values) - min(values)) or 0.5
    return linear_axis(min(values) - air, max(values) + air, title)


def _told(curve: LearningCurve, metric: str, text: Text) -> str:
    points = curve.known(metric)
    if not points:
        return f"{curve.reward}: no value"
    ends = [f"{text(point.value.mean)} after {point.steps:,} steps" for point in (points[0], points[-1])]
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
    known = [(float(point.steps), point.value.mean) for point in points if point.value.mean is not None]
    return [steps for steps, _ in known], [mean for _, mean in known]
