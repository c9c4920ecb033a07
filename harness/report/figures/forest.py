"""The forest plot of behaviour. For each measure it shows the difference and its interval."""

from collections.abc import Sequence
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from harness.eta.behaviour_change import Change
from harness.eta.headline import difference_of

WIDTH, HEIGHT = 168.0, 18.0
"""Width and height of one row, [px]."""
REACH = 74.0
"""Distance from 0 in the middle to the farthest end, [px]."""
MIDDLE = WIDTH / 2
NO_CHANGE = ("path", {"class": "one", "d": f"M{MIDDLE:g} 0V{HEIGHT:g}"})
"""The line in the middle."""
EXPLANATION = (
    "Dot and bar: the difference and its 95% interval. Each row has a scale of its own; the line is no difference, and "
    "what lies to its right is better, whether that means more or less."
)


def draw_strip(change: Change) -> str:
    """A row of the forest plot as an SVG element; empty if there is no difference to show, or nobody says its sides."""
    if change.difference is None or not change.measure.better:
        return ""
    return draw_interval(change, change.direction)


def draw_interval(change: Change, direction: str) -> str:
    """The difference and its interval as an SVG element, with what is better on the right.

    Args:
        change: What changed.
        direction: ``better`` or ``worse`` where a test says so, else empty.
    """
    kind, shapes = direction or "undecided", [NO_CHANGE]
    difference, ends = difference_of(change), [end for end in (change.low, change.high) if end is not None]
    reach, farthest = REACH * _side(change.measure.better), max(map(abs, [difference, *ends])) or 1.0
    if len(ends) == 2:
        left, right = sorted(MIDDLE + reach * end / farthest for end in ends)
        bar = {"class": f"line {kind}", "stroke-width": "2", "d": f"M{left:.1f} {HEIGHT / 2:g}H{right:.1f}"}
        shapes.append(("path", bar))
    at = {"cx": f"{MIDDLE + reach * difference / farthest:.1f}", "cy": f"{HEIGHT / 2:g}", "r": "4"}
    return _drawn(*shapes, ("circle", {"class": f"dot {kind}", **at}))


def draw_trainings(values: Sequence[float], ends: tuple[float, float], better: str, who: str) -> str:
    """A dot for each training as an SVG element, with what is better on the right.

    Args:
        values: The measure of each training.
        ends: The smallest and the largest value that the picture has room for.
        better: Whether ``higher`` or ``lower`` is better.
        who: The class of the colour, ``baseline`` or ``proposed``.
    """
    low, high = ends
    places = [(2.0 * value - low - high) / (high - low) if high > low else 0.0 for value in values]
    across = (f"{MIDDLE + REACH * _side(better) * place:.1f}" for place in places)
    kind, y = f"training {who}", f"{HEIGHT / 2:g}"
    return _drawn(*(("circle", {"class": kind, "cx": x, "cy": y, "r": "3.5"}) for x in across))


def draw_part(size: float, farthest: float, name: str) -> str:
    """A bar from no change to a part of a change, as an SVG element.

    Args:
        size: How large the part is, to the right if it is above 0.
        farthest: The largest part, which the picture has room for.
        name: Of its colour, such as ``ruler``.
    """
    end = MIDDLE + REACH * size / (farthest or 1.0)
    left, width = min(MIDDLE, end), max(abs(end - MIDDLE), 1.0)
    bar = {"class": f"bar {name}", "x": f"{left:.1f}", "y": "4", "width": f"{width:.1f}", "height": "10"}
    return _drawn(("rect", bar), NO_CHANGE)


def _side(better: str) -> float:
    """1 where more is better, else -1: what is better stands on the right."""
    return 1.0 if better == "higher" else -1.0


def _drawn(*shapes: tuple[str, dict[str, str]]) -> str:
    """A row: SVG elements with their attributes, the lowest first."""
    svg = Element("svg", {"class": "chart strip", "viewBox": f"0 0 {WIDTH:g} {HEIGHT:g}", "aria-hidden": "true"})
    for name, attributes in shapes:
        SubElement(svg, name, attributes)
    return ElementTree.tostring(svg, encoding="unicode")
