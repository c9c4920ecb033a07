"""The forest plot of behaviour. For each measure it shows the difference and its interval."""

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
    """A row of the forest plot as an SVG element; empty if there is no difference to show."""
    if change.difference is None:
        return ""
    ends = [end for end in (change.low, change.high) if end is not None]
    farthest = max(map(abs, [change.difference, *ends])) or 1.0
    sign = 1.0 if change.measure.better == "higher" else -1.0
    svg = Element("svg", {"class": "chart strip", "viewBox": f"0 0 {WIDTH:g} {HEIGHT:g}", "aria-hidden": "true"})
    middle, half = WIDTH / 2, HEIGHT / 2
    SubElement(svg, "path", {"class": "one", "d": f"M{middle:g} 0V{HEIGHT:g}"})
    kind = change.direction or "undecided"
    if len(ends) == 2:
        low, high = sorted(middle + REACH * sign * end / farthest for end in ends)
        SubElement(svg, "path", {"class": f"line {kind}", "stroke-width": "2", "d": f"M{low:.1f} {half:g}H{high:.1f}"})
    at = middle + REACH * sign * change.difference / farthest
    SubElement(svg, "circle", {"class": f"dot {kind}", "cx": f"{at:.1f}", "cy": f"{half:g}", "r": "4"})
    return ElementTree.tostring(svg, encoding="unicode")
