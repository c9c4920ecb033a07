"""Charts as SVG: marks lie where the axes say, and text is text."""

import math
import re
from xml.etree import ElementTree

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harness.report import Axis, Chart, Dots, Line, draw_chart, linear_axis
from harness.report.figures.chart import Area, Flag, Note, Word

CHARACTER = 6.9
"""Width of a character of a label, [px]."""

PLAIN = Axis(0.0, 10.0, "across", ((0.0, "0"), (10.0, "10")))
UP = Axis(-1.0, 1.0, "up", ((-1.0, "-1"), (0.0, "0"), (1.0, "1")))


def drawn_of(chart):
    """The figure, without its legend."""
    return ElementTree.fromstring(draw_chart(chart, "told").partition("<ul")[0])


def parts(chart, kind):
    """The elements of a class, by the figure that is drawn."""
    return [element for element in drawn_of(chart).iter() if kind in (element.get("class") or "").split()]


def points(path):
    """The corners of a path of one stretch: the first one, then how far it goes from each to the next."""
    begin, _, steps = path.get("d").removeprefix("M").rstrip("Z").partition("l")
    told = np.array(f"{begin} {steps}".split(), float).reshape(-1, 2)
    return [tuple(corner) for corner in told.cumsum(axis=0).round(1)]


def test_logarithmic_axis_has_equal_factors_equally_far_apart():
    """1, 10 and 100."""
    chart = Chart(Axis(1.0, 100.0, "", (), is_log=True), UP, (Line([1.0, 10.0, 100.0], [0.0, 0.0, 0.0], "ink"),))
    one, ten, hundred = (x for x, _ in points(parts(chart, "line")[0]))
    assert ten - one == pytest.approx(hundred - ten, abs=0.2)


def test_gap_interrupts_a_line():
    """The path begins anew behind it."""
    chart = Chart(PLAIN, UP, (Line([0.0, 1.0, math.nan, 2.0, 3.0], [0.0, 0.0, math.nan, 0.0, 0.0], "ink"),))
    assert re.sub(r"[^Ml]", "", parts(chart, "line")[0].get("d")) == "MlMl"


def test_a_path_of_many_points_stays_where_they_are():
    """Rounding to a tenth of a pixel does not add up."""
    x, y = np.linspace(0.0, 10.0, 1_001), np.sin(np.arange(1_001.0))
    chart = Chart(PLAIN, UP, (Line(x.tolist(), y.tolist(), "ink"),))
    (line,), (axis,) = parts(chart, "line"), parts(chart, "axis")
    (left, top), (_, bottom), (right, _) = points(axis)
    across, down = np.array(points(line)).T
    assert_allclose(across, left + (right - left) * x / 10.0, atol=0.11)
    assert_allclose(down, top + (bottom - top) * (1.0 - y) / 2.0, atol=0.11)


def test_what_has_no_points_is_not_drawn():
    """A path without points is an error to a browser."""
    chart = Chart(PLAIN, UP, (Line([], [], "ink"), Area([], [], "ink"), Dots([], [], "ink")))
    assert parts(chart, "line") == parts(chart, "area") == parts(chart, "dot") == []


def test_square_panel_is_as_high_as_wide():
    """Whatever its height says."""
    ((left, top), (_, bottom), (right, _)) = points(parts(Chart(PLAIN, UP, (), is_square=True), "axis")[0])
    assert bottom - top == pytest.approx(right - left, abs=0.2)
    assert right < 440.0


def test_names_are_text():
    """In the figure, under the pointer, in the legend and for those who cannot see it."""
    bad = "<script>alert('1')</script>\""
    marks = (Line([0.0], [0.0], "ink", bad, in_legend=True), Word(0.0, 0.0, bad), Flag(1.0, bad))
    drawn = draw_chart(Chart(PLAIN._replace(title=bad), UP, marks), bad)
    assert "<script" not in drawn
    assert drawn.count("&lt;script&gt;") == 6


def test_flags_have_room_above_the_panel():
    """As many lines of text as they have rows."""
    heights = [points(parts(Chart(PLAIN, UP, marks), "axis")[0])[0][1] for marks in ((), (Flag(1.0, "a", 1),))]
    assert heights[1] - heights[0] == pytest.approx(32.0)


def places(chart):
    """Where each text of the figure stands, [px]."""
    return {it.text: float(it.get("x")) for it in drawn_of(chart).iter("text")}


@pytest.mark.parametrize("x", [0.0, 10.0])
def test_a_word_stays_in_the_panel(x):
    """It is moved to the side where it would leave it."""
    chart = Chart(PLAIN, UP, (Word(x, 0.0, "a long word"),))
    ((left, _), _, (right, _)) = points(parts(chart, "axis")[0])
    half = CHARACTER * len("a long word") / 2
    assert left + half < places(chart)["a long word"] < right - half


def test_a_word_keeps_off_its_line():
    """One that begins at a point stands a little beside it."""
    drawn = places(Chart(PLAIN, UP, (Word(5.0, 0.0, "n/a", "start"), Word(5.0, 0.0, "x"))))
    assert drawn["n/a"] == drawn["x"] + 4.0


def test_notes_have_room_beside_the_panel():
    """Whatever is written there, the figure is as wide as it says."""
    chart = Chart(PLAIN, UP, (Note(0.0, "a long note"),), width=300.0)
    (right, _) = points(parts(chart, "axis")[0])[-1]
    assert right < places(chart)["a long note"] <= 300.0 - CHARACTER * len("a long note")


def test_figure_is_as_large_as_it_says():
    """Its legend not counted."""
    assert drawn_of(Chart(PLAIN, UP, (Flag(1.0, "a", 1),), width=300.0)).get("viewBox") == "0 0 300 274"


def test_legend_names_marks_in_their_order():
    """Those that have a name for it."""
    line = Line([0.0], [0.0], "ink", "a line", in_legend=True)
    dots = Dots([0.0], [0.0], "ink", legend="a dot")
    drawn = draw_chart(Chart(PLAIN, UP, (dots, line, line._replace(in_legend=False))), "told")
    assert re.findall(r'class="(dot|line) .*?<span>([^<]*)</span>', drawn.partition("<ul")[2]) == [
        *(("dot", "a dot"), ("line", "a line")),
    ]


def test_hidden_characters_are_written_out():
    """A browser would obey some of them; XML has no place for others."""
    drawn = draw_chart(Chart(PLAIN._replace(title="a\x1b"), UP, (Word(0.0, 0.0, "b\u202e"),)), "c\x00")
    assert all(text in drawn for text in (r"a\x1b", r"b\u202e", r"c\x00"))


def test_no_colour_is_fixed():
    """The style sheet gives colours for light and dark screens."""
    marks = (Line([0, 1], [0, 1], "baseline"), Dots([0], [0], "proposed"), Area([0, 1], [0, 1], "random"))
    drawn = draw_chart(Chart(PLAIN, UP, marks), "told")
    assert not re.search(r'#[0-9a-fA-F]{3,6}|rgb\(|(fill|stroke)="', drawn)


def test_ticks_are_round_few_and_inside(subtests):
    """At least two, whatever the span."""
    for high in [0.003, 1.0, 7.0, 99.0, 19_999.0, 2e6]:
        with subtests.test(high=high):
            ticks = [tick for tick, _ in linear_axis(0.0, high, "", 5).ticks]
            assert 2 <= len(ticks) <= 6
            assert ticks[0] == 0.0
            assert ticks[-1] <= high
            digits = {f"{tick / 10 ** math.floor(math.log10(tick)):.6g}" for tick in ticks[1:]}
            assert all(len(digit) <= 4 for digit in digits)


def test_axes_have_readable_numbers():
    """Thousands apart."""
    assert [text for _, text in linear_axis(0.0, 20_000.0, "", 5).ticks] == ["0", "5,000", "10,000", "15,000", "20,000"]


def test_a_symbol_has_a_subscript():
    """Lowered and smaller; what follows stands where the text began."""
    (text,) = (it for it in drawn_of(Chart(PLAIN, UP, (Word(5.0, 0.0, "eta_N = 2 x I_P"),))).iter("text") if len(it))
    assert "".join(text.itertext()) == "ηN = 2 × IP"
    assert [(it.text, it.get("dy"), it.get("font-size")) for it in text] == [
        ("N", "3", "75%"), (" = 2 × I", "-3", None), ("P", "3", "75%"),
    ]  # fmt: skip
