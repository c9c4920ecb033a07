"""Static figures as files."""

import re
import xml.etree.ElementTree as ET

import pytest

from harness.report.figures.chart import Chart, Dots, Flag, Line, Note, linear_axis
from harness.report.figures.draw import CHARACTER
from harness_plugins.committed.svg import CREATOR, TitledChart, chart_style, draw_svg

SVG = "{http://www.w3.org/2000/svg}"
SIZE = 150_000
"""Bytes."""
LARGE = {"seeds": 12, "baseline": (4_000, 9_000), "proposed": {"arp": (3_000, 7_000)}, "learned": {10: 1, 20: 2}}
LABEL = "<k2> & a label " + "that is long " * 30
CHART = Chart(
    linear_axis(0.0, 1.0, "across"),
    linear_axis(0.0, 1.0, "up"),
    (Line([0.0, 1.0], [0.0, 1.0], "baseline", LABEL, in_legend=True), Note(0.5, "near zero")),
)


@pytest.fixture(scope="module")
def figure():
    """Two panels of one chart under a long headline."""
    return draw_svg("a title", ("first", LABEL), [TitledChart("one", CHART), TitledChart(LABEL, CHART)], [LABEL])


def texts(svg):
    """Each text and, if it begins at its place, where it begins and ends, [px]."""
    for parent in ET.fromstring(svg).iter():
        for node in parent.findall(f"{SVG}text"):
            left = float(node.get("x")) + float(parent.get("x", 0.0))
            yield node.text, left, left + CHARACTER * len(node.text), node.get("text-anchor", "start")


def test_figures_are_well_formed_small_and_ours(summarise):
    """Of an experiment of twelve long runs: XML that loads and runs nothing, and says who wrote it."""
    figures = {path.name.split(".")[-2]: path.read_text() for path in (summarise(**LARGE) / "figures").glob("*.svg")}
    assert set(figures) == {"overview", "runs", "split", "learning"}
    for text in figures.values():
        assert ET.fromstring(text).tag == f"{SVG}svg"
        assert len(text) < SIZE
        assert CREATOR in text
        assert not re.search(r"<script|href|url\(|@import|@font-face", text)
        assert re.findall(r"https?://[^\"]*", text) == ["http://www.w3.org/2000/svg"]


def test_background_is_white(figure):
    """On a dark page too: the first thing drawn covers everything."""
    first = next(node for node in ET.fromstring(figure) if node.tag in (f"{SVG}rect", f"{SVG}text", f"{SVG}svg"))
    assert first.attrib == {"width": "100%", "height": "100%", "style": "fill: #fff"}


def test_every_colour_is_written_in():
    """Those of the page on a light screen, in the place of their names."""
    style = chart_style()
    assert "var(" not in style
    assert ".chart .baseline, .chart .pair-0 { color: #5b6877; }" in style
    assert ".chart .open { fill: #fff; }" in style


def test_every_mark_has_a_rule(summarise):
    """No class of a figure is without one: it would be black."""
    style = chart_style()
    for path in (summarise(seeds=2, learned={10: 1}) / "figures").glob("*.svg"):
        kinds = {kind for node in ET.parse(path).iter() for kind in node.get("class", "").split()}
        assert {kind for kind in kinds - {"chart", "sample"} if f".chart .{kind}" not in style} == set()


def test_text_is_text_and_inside(figure):
    """As it was given, and broken where the figure ends."""
    width = float(ET.fromstring(figure).get("width"))
    given = list(texts(figure))
    assert sum(text.startswith("<k2> & a label") for text, *_ in given) == 4
    assert max(end for _, _, end, anchor in given if anchor == "start") < width
    assert min(begin for _, begin, *_ in given) > 0.0


def test_legend_has_every_name_once(figure):
    """Though both panels have it."""
    assert len([node for node in ET.fromstring(figure).iter() if node.get("class") == "chart sample"]) == 1


def test_panels_stand_below_one_another():
    """Each where the one above it ended, so that a phone shows them as large as a page does."""
    flagged = CHART._replace(marks=(Flag(0.5, "here", 1),))
    svg = ET.fromstring(draw_svg("a title", ("first",), [TitledChart("one", flagged), TitledChart(LABEL, CHART)]))
    one, other = (node for node in svg if node.get("role") == "img")
    assert one.get("x") == other.get("x")
    assert float(one.get("y")) + float(one.get("height")) < float(other.get("y"))
    assert float(svg.get("width")) < 1.1 * CHART.width


def test_samples_of_dots_are_drawn():
    """As those of lines are."""
    chart = CHART._replace(marks=(Dots([0.5], [0.5], "ink", legend="a dot"),))
    svg = ET.fromstring(draw_svg("a title", ("first",), [TitledChart("", chart)]))
    (sample,) = (node for node in svg.iter() if node.get("class") == "chart sample")
    assert [node.get("class") for node in sample] == ["dot ink"]


def test_hidden_characters_are_written_out():
    """XML has no place for most of them."""
    svg = draw_svg("a\x00", ("b\x1b",), [TitledChart("c\x01", CHART._replace(marks=()))], ["d\u202e"])
    assert {r"b\x1b", r"c\x01", r"d\u202e"} <= {text for text, *_ in texts(svg)}


def test_same_numbers_same_bytes(figure):
    """There is no date and no random id."""
    again = draw_svg("a title", ("first", LABEL), [TitledChart("one", CHART), TitledChart(LABEL, CHART)], [LABEL])
    assert figure == again


def test_a_subscript_stands_beside_its_symbol():
    """No line break of the file comes between them: it would be a space."""
    svg = ET.fromstring(draw_svg("a title", ("eta_N of it",), [TitledChart("one", CHART)]))
    assert [it for it in ("".join(node.itertext()) for node in svg.iter(f"{SVG}text")) if "η" in it] == ["ηN of it"]
