"""Static figures as files."""

import xml.etree.ElementTree as ET

import matplotlib as mpl

from harness.report.summary.svg import CREATOR, draw_svg

SIZE = 150_000
"""Bytes."""
LARGE = {"seeds": 12, "baseline": (4_000, 9_000), "proposed": {"arp": (3_000, 7_000)}, "learned": {10: 1, 20: 2}}


def draw(figure):
    """A line, and a label that could be taken for a formula."""
    axes = figure.subplots()
    axes.plot([0.123456789, 1.0], [0.987654321, 2.0])
    axes.set_title("$k_1$ & <k2>")


def test_figures_are_well_formed_small_and_ours(summarise):
    """Of an experiment of twelve long runs: XML that loads nothing, says who wrote it, and has no date."""
    paths = (summarise(**LARGE) / "figures").glob("*.svg")
    figures = {path.name.split(".")[-2]: path.read_text() for path in paths}
    assert set(figures) == {"overview", "runs", "split", "learning"}
    for text in figures.values():
        root = ET.fromstring(text)
        assert root.tag == "{http://www.w3.org/2000/svg}svg"
        assert len(text) < SIZE
        assert CREATOR in text
        assert "<!DOCTYPE" not in text
        assert "dc:date" not in text


def test_background_is_white():
    """On a dark page too: the first thing drawn covers everything."""
    svg = ET.fromstring(draw_svg("a title", 3.0, 2.0, draw))
    patch = next(node for node in svg.iter() if node.get("id") == "patch_1")
    assert "fill: #ffffff" in patch[0].get("style")


def test_text_is_text():
    """As it was given, no formula, and escaped."""
    svg = draw_svg("a title", 3.0, 2.0, draw).decode()
    words = [node.text for node in ET.fromstring(svg).iter("{http://www.w3.org/2000/svg}text")]
    assert "$k_1$ & <k2>" in words


def test_same_numbers_same_bytes():
    """Ids and metadata included, whatever the user's own settings are."""
    before = draw_svg("a title", 3.0, 2.0, draw)
    with mpl.rc_context({"font.size": 30, "svg.fonttype": "path", "axes.facecolor": "#000000"}):
        after = draw_svg("a title", 3.0, 2.0, draw)
    assert before == after


def test_settings_of_the_user_stay():
    """Drawing leaves them as they were."""
    with mpl.rc_context({"font.size": 30}):
        draw_svg("a title", 3.0, 2.0, draw)
        assert mpl.rcParams["font.size"] == 30
