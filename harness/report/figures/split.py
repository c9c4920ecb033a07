"""The figure of ruler x behaviour: an eta and its parts on a logarithmic axis, each with its interval."""

from collections.abc import Iterable, Iterator

from harness.eta.splits import Split
from harness.report.figures.chart import Axis, Chart, Dots, Line, Mark, Word
from harness.report.figures.ratio_axis import interval_ends, is_drawable, named_ticks, ratio_range
from harness.report.figures.split_rows import SplitRow, has_parts, split_rows
from harness.report.rows.comparison import better_of, ratio_with_interval

LOWEST = 7.1
"""Place of the axis, counted down from the top."""


def draw_split(name: str, split: Split) -> Chart | None:
    """The figure of an eta and both of its paths; None if no part has a value."""
    rows = split_rows(name, split)
    if not has_parts(rows):
        return None
    names = tuple((-row.place, row.label) for row in rows)
    ratios = ratio_axis(name, rows)
    marks = [mark for row in rows for mark in (*draw_ratio(row, ratios), _number(row))]
    return Chart(ratios, Axis(-LOWEST, 0.9, "", names, has_grid=False), tuple(marks), height=262.0)


def ratio_axis(name: str, rows: Iterable[SplitRow]) -> Axis:
    """A logarithmic axis for all that can be drawn of these rows of the eta of that name."""
    low, high = ratio_range([row.ratio for row in rows])
    return Axis(low, high, f"ratio; {better_of(name)} is called better", named_ticks(low, high), is_log=True)


def draw_ratio(row: SplitRow, axis: Axis) -> Iterator[Mark]:
    """The marks of a ratio: its interval, with the point on it. Empty if the axis has no place for it."""
    if not is_drawable(row.ratio) or row.ratio.value is None:
        return
    ends = interval_ends(row.ratio, axis.low, axis.high)
    if ends is not None:
        yield Line(list(ends), [-row.place] * 2, row.colour)
    told = f"{row.label}: {ratio_with_interval(row.ratio)}"
    yield Dots([row.ratio.value], [-row.place], row.colour, (told,), row.shape, row.is_open, 4.5)


def _number(row: SplitRow) -> Word:
    """The number and its interval above the point; a word if there is no point."""
    if not is_drawable(row.ratio) or row.ratio.value is None:
        return Word(1.0, -row.place, ratio_with_interval(row.ratio), "start")
    return Word(row.ratio.value, -row.place, ratio_with_interval(row.ratio), rise=13.0)
