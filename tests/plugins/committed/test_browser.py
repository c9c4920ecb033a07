"""The figures of records as a browser draws them: no text touches another one or a mark, and nothing is cut."""

from typing import NamedTuple

import pytest

from harness.report.figures.chart import Chart, Note, Word, linear_axis
from harness_plugins.committed import TitledChart, draw_svg
from tests.project import ROOT

pytestmark = pytest.mark.slow
REFERENCE = ROOT / "results" / "reference"
FIGURES = sorted(REFERENCE.rglob("*.svg"))
BOXES = """(kind) => [...document.querySelectorAll(kind)].map((it) => {
  const box = it.getBoundingClientRect()
  return [it.textContent.trim(), box.x, box.y, box.right, box.bottom]
})"""
BESIDE, ABOVE = 1.5, 4.0
"""How far two boxes may overlap, [px]: those of texts are higher than their letters."""


class Box(NamedTuple):
    """What a text or a mark covers, [px]."""

    text: str
    left: float
    top: float
    right: float
    bottom: float

    def touches(self, other):
        """Whether both cover the same place."""
        across = min(self.right, other.right) - max(self.left, other.left)
        return across > BESIDE and min(self.bottom, other.bottom) - max(self.top, other.top) > ABOVE


def faults(page, figure):
    """What touches something, or is cut."""
    page.goto(figure.as_uri())
    width, height = page.evaluate("['width', 'height'].map((it) => Number(document.documentElement.getAttribute(it)))")
    texts, dots = ([Box(*it) for it in page.evaluate(BOXES, kind)] for kind in ("text", "path.dot"))
    cut = [it.text for it in texts if min(it.left, it.top) < 0.0 or it.right > width or it.bottom > height]
    pairs = [(one, other) for place, one in enumerate(texts) for other in (*texts[place + 1 :], *dots)]
    return [*cut, *(f"{one.text} | {other.text}" for one, other in pairs if one.touches(other))]


def test_no_text_of_a_committed_figure_touches_another_or_is_cut(show):
    """Of none."""
    page = show("about:blank")
    found = {it.relative_to(REFERENCE).as_posix(): faults(page, it) for it in FIGURES}
    assert {name: told for name, told in found.items() if told} == {}


def test_texts_that_touch_or_are_cut_are_found(show, tmp_path):
    """The mutants: two words at one place, and one that is wider than the figure says."""
    axis = linear_axis(0.0, 1.0, "")
    chart = Chart(axis, axis, (Word(0.5, 0.5, "one"), Word(0.5, 0.5, "other"), Note(0.5, "WWWWWWWWWWWWWWW")))
    figure = tmp_path / "figure.svg"
    figure.write_bytes(draw_svg("a title", ("first",), [TitledChart("", chart)]))
    assert faults(show("about:blank"), figure) == ["WWWWWWWWWWWWWWW", "one | other"]
