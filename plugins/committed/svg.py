"""Charts as an SVG file: colours written in, no script, no font, the same bytes from the same numbers."""

import textwrap
from collections.abc import Sequence
from typing import NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from harness.report import Chart, Dots, Line, typeset
from harness.report.figures.chart import chart_style
from harness.report.figures.draw import (
    CHARACTER,
    SAMPLE,
    draw_figure,
    draw_sample,
    figure_height,
    legend_of,
    panel_left,
    set_text,
    width_of,
)
from harness.text import visible

CREATOR = "harness report --summary"
"""The creator that is written into every figure. It tells which figures in a folder are ours."""
INTERVALS = "Bars: 95% intervals over seeds; one that ends at the edge of its panel goes on."
FONT = (
    "font-family: system-ui, -apple-system, 'Segoe UI', Roboto, 'Noto Sans', 'Liberation Sans', "
    "'Helvetica Neue', Arial, sans-serif"
)
EDGE = 16.0
"""Margin around the figure, [px]."""
LINE = 18.0
"""Height of a line of text, [px]."""
BOLD = 1.12
"""How much wider a bold text is."""


class TitledChart(NamedTuple):
    """A chart and its heading."""

    heading: str
    """The heading; empty if the headline says it."""
    chart: Chart


def draw_svg(title: str, headline: Sequence[str], panels: Sequence[TitledChart], notes: Sequence[str] = ()) -> bytes:
    """A figure as a file: the headline, the panels one below the other, which a phone shows too, one legend, notes.

    Args:
        title: What it shows, for those who cannot see it.
        headline: Paragraphs; the first is bold.
        panels: The panels from top to bottom, at least one.
        notes: Paragraphs below.
    """
    width = 2 * EDGE + max(panel.chart.width for panel in panels)
    svg = Element("svg", {"xmlns": "http://www.w3.org/2000/svg", "class": "chart", "style": FONT, "role": "img"})
    SubElement(svg, "title").text = visible(title)
    SubElement(svg, "metadata").text = CREATOR
    SubElement(svg, "style").text = chart_style()
    SubElement(svg, "rect", {"width": "100%", "height": "100%", "style": "fill: #fff"})  # readable on a dark page too
    room = width - 2 * EDGE
    y = EDGE
    for number, text in enumerate(headline):
        y = _write(svg, EDGE, y, text, room, is_bold=number == 0)
    y = _draw_panels(svg, panels, y + LINE / 2, title)
    y = _draw_legend(svg, panels, y, room)
    for text in notes:
        y = _write(svg, EDGE, y, text, room)
    height = y + EDGE
    svg.attrib.update({"viewBox": f"0 0 {width:g} {height:g}", "width": f"{width:g}", "height": f"{height:g}"})
    _indent(svg)
    text = ElementTree.tostring(svg, encoding="unicode")
    return f"{text}\n".encode()


def _indent(svg: Element) -> None:
    """Give each element a line, so that what changed can be seen; a text with subscripts stays in one."""
    ElementTree.indent(svg, space="")
    for text in svg.iter("text"):
        text.text = (text.text or "").strip("\n")
        for piece in text:
            piece.tail = None


def _draw_panels(svg: Element, panels: Sequence[TitledChart], y: float, title: str) -> float:
    """Draw each heading and its chart below; returns where they end."""
    for panel in panels:
        left = panel_left(panel.chart)
        y = _write(svg, EDGE + left, y, panel.heading, panel.chart.width - left, is_bold=True)
        figure, height = draw_figure(panel.chart, panel.heading or title), figure_height(panel.chart)
        _place(svg, figure, EDGE, y, (panel.chart.width, height))
        y += height + LINE / 2
    return y


def _draw_legend(svg: Element, panels: Sequence[TitledChart], y: float, room: float) -> float:
    """Draw every name once, in lines as long as there is room; returns where they end."""
    named: dict[str, Line | Dots] = {}
    for panel in panels:
        for name, mark in legend_of(panel.chart):
            named.setdefault(name, mark)
    x = EDGE
    for name, mark in named.items():
        taken = SAMPLE[0] + 6.0 + width_of(name)
        if x > EDGE and x + taken > EDGE + room:
            x, y = EDGE, y + LINE
        _place(svg, draw_sample(mark), x, y + (LINE - SAMPLE[1]) / 2, SAMPLE)
        y = _write(svg, x + SAMPLE[0] + 6.0, y, name, room - SAMPLE[0] - 6.0) - LINE
        x += taken + 1.5 * LINE
    return y + 1.5 * LINE if named else y


def _place(svg: Element, figure: Element, x: float, y: float, size: tuple[float, float]) -> None:
    figure.attrib.update(dict(zip(("x", "y", "width", "height"), (f"{it:g}" for it in (x, y, *size)), strict=True)))
    svg.append(figure)


def _write(svg: Element, x: float, y: float, text: str, room: float, is_bold: bool = False) -> float:
    """Write as many lines as the text needs; returns where they end."""
    printed = typeset(visible(text))
    character = max(CHARACTER, width_of(printed) / max(1, len(printed))) * (BOLD if is_bold else 1.0)
    for line in textwrap.wrap(printed, int(room / character)):
        element = SubElement(svg, "text", {"x": f"{x:g}", "y": f"{y + 0.75 * LINE:g}"})
        set_text(element, line)
        if is_bold:
            element.set("font-weight", "bold")
        y += LINE
    return y
