"""The figure of ruler x behaviour: an eta and its parts on a logarithmic axis, each with its interval."""

from collections.abc import Iterable, Iterator

from harness.eta.splits import Split
from harness.report.figures.chart import Axis, Chart, Dots, Line, Mark, Note
from harness.report.figures.ratio_axis import interval_ends, named_ticks, ratio_range
from harness.report.figures.split_rows import PATHS, SplitRow, split_rows
from harness.report.rows.ratios import NEITHER, better_of, is_drawable, ratio_with_interval

ROW, AIR = 24.0, 0.9
"""Height of a row, [px]; space above the first and below the last one, in rows."""


def draw_split(name: str, split: Split) -> Chart | None:
    """The figure of an eta and both of its paths; None if no part has a value."""
    rows = split_rows(name, split)
    if not any(is_drawable(row.ratio) for row in rows[1:]):
        return None
    lowest = rows[-1].place + AIR
    names = [(-row.place, row.label.partition(",")[0]) for row in rows]
    names += [(-top, where) for where, top in PATHS if top < lowest]
    ratios = ratio_axis(name, rows)
    marks = [mark for row in rows for mark in (*draw_ratio(row, ratios), number_of(row))]
    places = Axis(-lowest, AIR, "", tuple(names), has_grid=False)
    return Chart(ratios, places, tuple(marks), height=ROW * (lowest + AIR))


def ratio_axis(name: str, rows: Iterable[SplitRow]) -> Axis:
    """A logarithmic axis for all that can be drawn of these rows of the eta of that name."""
    low, high = ratio_range([row.ratio for row in rows])
    side = better_of(name)
    called = f"; {side} is called better" if side != NEITHER else ""
    return Axis(low, high, f"ratio{called}", named_ticks(low, high), is_log=True)


def draw_ratio(row: SplitRow, axis: Axis) -> Iterator[Mark]:
    """The marks of a ratio: its interval, with the point on it. Empty if the axis has no place for it."""
    if not is_drawable(row.ratio) or row.ratio.value is None:
        return
    ends = interval_ends(row.ratio, axis.low, axis.high)
    if ends is not None:
        yield Line(list(ends), [-row.place] * 2, row.colour)
    told = f"{row.label}: {ratio_with_interval(row.ratio)}"
    yield Dots([row.ratio.value], [-row.place], row.colour, (told,), row.shape, row.is_open, 4.5)


def number_of(row: SplitRow) -> Note:
    """The number and its interval at the right of the panel, or the word that stands in its place."""
    return Note(-row.place, ratio_with_interval(row.ratio))
