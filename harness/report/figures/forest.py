"""The forest plot of behaviour. For each measure it shows the difference and its interval."""

from collections.abc import Sequence
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from harness.eta.behaviour_change import Change

WIDTH, HEIGHT = 168.0, 18.0
"""Width and height of one row, [px]."""
REACH = 74.0
"""Distance from 0 in the middle to the farthest end, [px]."""
EXPLANATION = (
    "Dot and bar: the difference and its 95% interval. Each row has a scale of its own; the line is no difference, and "
    "what lies to its right is better, whether that means more or less."
)


def draw_strip(change: Change) -> str:
    """A row of the forest plot as an SVG element; empty if there is no difference to show, or nobody says its sides."""
    if change.difference is None or not change.measure.better:
        return ""
    return draw_interval(change.difference, change.low, change.high, change.measure.better, change.direction)


def draw_interval(difference: float, low: float | None, high: float | None, better: str, direction: str) -> str:
    """A difference and its interval as an SVG element, with what is better on the right.

    Args:
        difference: The dot.
        low: The lower end of the bar; None where there is none.
        high: The upper end.
        better: Whether ``higher`` or ``lower`` is better.
        direction: ``better`` or ``worse`` where a test says so, else empty.
    """
    ends = [end for end in (low, high) if end is not None]
    farthest = max(map(abs, [difference, *ends])) or 1.0
    sign = 1.0 if better == "higher" else -1.0
    svg = Element("svg", {"class": "chart strip", "viewBox": f"0 0 {WIDTH:g} {HEIGHT:g}", "aria-hidden": "true"})
    middle, half = WIDTH / 2, HEIGHT / 2
    SubElement(svg, "path", {"class": "one", "d": f"M{middle:g} 0V{HEIGHT:g}"})
    kind = direction or "undecided"
    if len(ends) == 2:
        left, right = sorted(middle + REACH * sign * end / farthest for end in ends)
        SubElement(
            svg, "path", {"class": f"line {kind}", "stroke-width": "2", "d": f"M{left:.1f} {half:g}H{right:.1f}"}
        )
    at = middle + REACH * sign * difference / farthest
    SubElement(svg, "circle", {"class": f"dot {kind}", "cx": f"{at:.1f}", "cy": f"{half:g}", "r": "4"})
    return ElementTree.tostring(svg, encoding="unicode")


def draw_trainings(values: Sequence[float], ends: tuple[float, float], better: str, who: str) -> str:
    """A dot for each training as an SVG element, with what is better on the right.

    Args:
        values: The measure of each training.
        ends: The smallest and the largest value that the picture has room for.
        better: Whether ``higher`` or ``lower`` is better.
        who: The class of the colour, ``baseline`` or ``proposed``.
    """
    low, high = ends
    svg = Element("svg", {"class": "chart strip", "viewBox": f"0 0 {WIDTH:g} {HEIGHT:g}", "aria-hidden": "true"})
    sign = 1.0 if better == "higher" else -1.0
    for value in values:
        place = (2.0 * value - low - high) / (high - low) if high > low else 0.0
        at = {"cx": f"{WIDTH / 2 + REACH * sign * place:.1f}", "cy": f"{HEIGHT / 2:g}", "r": "3.5"}
        SubElement(svg, "circle", {"class": f"training {who}", **at})
    return ElementTree.tostring(svg, encoding="unicode")


def draw_part(size: float, farthest: float, name: str) -> str:
    """A bar from no change to a part of a change, as an SVG element.

    Args:
        size: How large the part is, to the right if it is above 0.
        farthest: The largest part, which the picture has room for.
        name: Of its colour, such as ``ruler``.
    """
    svg = Element("svg", {"class": "chart strip", "viewBox": f"0 0 {WIDTH:g} {HEIGHT:g}", "aria-hidden": "true"})
    middle = WIDTH / 2
    end = middle + REACH * size / (farthest or 1.0)
    left, width = min(middle, end), max(abs(end - middle), 1.0)
    SubElement(
        svg, "rect", {"class": f"bar {name}", "x": f"{left:.1f}", "y": "4", "width": f"{width:.1f}", "height": "10"}
    )
    SubElement(svg, "path", {"class": "one", "d": f"M{middle:g} 0V{HEIGHT:g}"})
    return ElementTree.tostring(svg, encoding="unicode")
