"""Ratios on a logarithmic axis."""

from itertools import pairwise

import matplotlib.style
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from harness.eta.index import Ratio
from harness.report.palette import INK
from harness.report.split_rows import SplitRow
from harness.report.summary.headline import WIDTH
from harness.report.summary.ratio_marks import draw_marks
from harness.report.summary.svg import STYLE

NAMES = ["behaviour, other path"] * 2


@pytest.fixture
def draw():
    """Draws two ratios in each of two panels, with long numbers beside them; returns the second panel."""

    def panel(*values: float):
        rows = [
            SplitRow("", Ratio(value, 0.8 * value, 1.3 * value), k, INK, "circle") for k, value in enumerate(values)
        ]
        with matplotlib.style.context(["default", STYLE]):
            figure = Figure(figsize=(WIDTH, 4.0), layout="constrained")
            canvas = FigureCanvasAgg(figure)
            for axes in figure.subplots(1, 2, sharey=True):
                draw_marks(axes, rows, with_intervals=True)
                axes.set_yticks([row.place for row in rows], NAMES)
            canvas.draw()
        return axes

    return panel


def _names(axes):
    return [label.get_text() for label in axes.get_xticklabels()]


@pytest.mark.parametrize("low", [0.95, 0.5, 0.05, 0.001, 2e-4, 1e-5, 1e-8])
@pytest.mark.parametrize("high", [1.3, 2.0, 20.0, 3e3, 1e8])
def test_labels_of_the_axis_keep_apart(draw, low, high):
    """By half a character or more, whatever the ratios span."""
    boxes = [label.get_window_extent() for label in draw(low, high).get_xticklabels()]
    apart = [right.x0 - left.x1 for left, right in pairwise(boxes)]
    assert min(apart) > 4.0  # [pixel]; of a character some 9


@pytest.mark.parametrize("high", [1.3, 20.0, 1e8])
def test_one_is_marked(draw, high):
    """Wherever labels are left out."""
    assert "1" in _names(draw(0.001, high))


def test_long_powers_are_short(draw):
    """Digits where they are few."""
    assert _names(draw(2e-4, 0.9)) == ["1e-4", "0.01", "1"]
