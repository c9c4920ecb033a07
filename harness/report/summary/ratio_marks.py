"""Ratios on a logarithmic axis: a mark and its interval each, the numbers beside the panel."""

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from harness.eta.index import Ratio
from harness.report.palette import INK
from harness.report.ratio_axis import interval_ends, is_drawable, ratio_range, ticks
from harness.report.rows import ratio_text, ratio_with_interval
from harness.report.split_rows import SplitRow

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SHAPES = {"circle": "o", "square": "s", "diamond": "D"}


FARTHEST = 30.0
"""An interval ends no farther than this factor beyond the outermost ratio: its ends stand in numbers beside it."""
ENDLESS = "Bars: 95% intervals over seeds; one without an end goes on."
ROOM = 18
"""Characters beside one another along the axis: it is narrow where long numbers stand beside the panel."""


def draw_marks(axes: "Axes", rows: Iterable[SplitRow], with_intervals: bool) -> None:
    """Rows of ratios; the number of each, or the word in its place, stands to the right, maybe with its interval."""
    rows = list(rows)
    low, high = set_ratio_axis(axes, [row.ratio for row in rows])
    for row in rows:
        if is_drawable(row.ratio):
            _mark(axes, row, low, high)
        text = ratio_with_interval(row.ratio) if with_intervals else ratio_text(row.ratio)
        axes.annotate(
            text,
            (1.0, row.place),
            xycoords=("axes fraction", "data"),
            xytext=(6, 0),
            textcoords="offset points",
            va="center",
            fontsize=9,
            annotation_clip=False,
        )


def set_ratio_axis(axes: "Axes", ratios: Sequence[Ratio]) -> tuple[float, float]:
    """Make the horizontal axis one for these ratios, with a line at 1; returns its ends."""
    low, high = ratio_range(ratios, FARTHEST)
    axes.set_xscale("log")
    axes.set_xlim(low, high)
    marks = _thin(ticks(low, high), high / low)
    axes.set_xticks(marks, [_name(mark) for mark in marks])
    axes.minorticks_off()
    axes.tick_params(axis="y", length=0)
    axes.grid(visible=False, axis="y")
    axes.axvline(1.0, color=INK, linewidth=1.2, zorder=1)
    return low, high


def _mark(axes: "Axes", row: SplitRow, low: float, high: float) -> None:
    value, ends = row.ratio.value or 0.0, interval_ends(row.ratio, low, high)
    if ends is not None:
        axes.plot(ends, (row.place, row.place), color=row.colour, linewidth=1.6)
        caps = [end for end in ends if end in (row.ratio.low, row.ratio.high)]  # none where the axis ends before it
        axes.plot(caps, [row.place] * len(caps), "|", color=row.colour, markeredgewidth=1.6, markersize=7)
    shape, _, is_open = row.symbol.partition("-")
    style: dict[str, Any] = {"markeredgecolor": row.colour, "markeredgewidth": 1.6, "markersize": 7, "zorder": 5}
    style["markerfacecolor"] = "#ffffff" if is_open else row.colour
    axes.plot([value], [row.place], SHAPES[shape], clip_on=False, **style)


def _thin(marks: list[float], span: float) -> list[float]:
    """Every second one, 1 among them, as long as two neighbours touch on an axis of that span, its high by its low."""
    while len(marks) > 2 and any(_touch(*pair, span) for pair in pairwise(marks)):
        marks = marks[marks.index(1.0) % 2 :: 2]
    return marks


def _touch(left: float, right: float, span: float) -> bool:
    """Whether there is less than a character between their names."""
    apart = ROOM * math.log(right / left) / math.log(span)
    return apart < (len(_name(left)) + len(_name(right))) / 2 + 1


def _name(mark: float) -> str:
    """The number; a power of ten that is long in digits as 1e-4 or 1e5."""
    return f"{mark:,g}" if 0.001 <= mark <= 1_000 else f"1e{math.log10(mark):.0f}"
