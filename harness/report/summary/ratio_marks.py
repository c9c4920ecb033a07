"""Ratios on a logarithmic axis: a mark and its interval each, the numbers beside the panel."""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from harness.index import Ratio
from harness.report.palette import INK
from harness.report.ratio_axis import interval_ends, is_drawable, ratio_range, ticks
from harness.report.rows import NOTHING, interval_text, ratio_text
from harness.report.split_rows import SplitRow

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SHAPES = {"circle": "o", "square": "s", "diamond": "D"}


FARTHEST = 30.0
"""An interval ends no farther than this factor beyond the outermost ratio: its ends stand in numbers beside it."""
ENDLESS = "Bars: 95% intervals over seeds; one without an end goes on."
ROOM = 28
"""Characters of all marked numbers together, each with two for its surroundings."""


def draw_marks(axes: "Axes", rows: Iterable[SplitRow], with_intervals: bool) -> None:
    """Rows of ratios; the number of each, or the word in its place, stands to the right, maybe with its interval."""
    rows = list(rows)
    low, high = set_ratio_axis(axes, [row.ratio for row in rows])
    for row in rows:
        if is_drawable(row.ratio):
            _mark(axes, row, low, high)
        text = _number(row.ratio, with_intervals)
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
    marks = _thin(ticks(low, high))
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


def _thin(marks: list[float]) -> list[float]:
    """Every second one, 1 among them, as long as they have no room."""
    while len(marks) > 2 and sum(len(_name(mark)) + 2 for mark in marks) > ROOM:
        marks = marks[marks.index(1.0) % 2 :: 2]
    return marks


def _name(mark: float) -> str:
    return f"{mark:,g}"


def _number(ratio: Ratio, with_interval: bool) -> str:
    interval = interval_text(ratio)
    return f"{ratio_text(ratio)} {interval}" if with_interval and interval != NOTHING else ratio_text(ratio)
