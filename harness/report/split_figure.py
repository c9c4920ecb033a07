"""The figure of ruler x behaviour: an eta and its parts on a logarithmic axis, each with its interval."""

from collections.abc import Iterator

from harness.eta.decompose import Split
from harness.report.chart import Axis, Chart, Dots, Line, Mark, Shape, Word
from harness.report.palette import GREEN, GREY, INK
from harness.report.ratio_axis import interval_ends, is_drawable, ratio_range, ticks
from harness.report.rows import BETTER, interval_text, ratio_text
from harness.report.split_rows import SplitRow, has_parts, split_rows

LOWEST = 7.1
"""Place of the axis, down from the top."""
COLOURS = {INK: "ink", GREY: "ruler", GREEN: "behaviour"}
"""What a row's colour is called on a page."""
SHAPES: dict[str, Shape] = {"circle": "circle", "square": "square", "diamond": "diamond"}


def draw_split(name: str, split: Split) -> Chart | None:
    """An eta and both of its paths; None where no part has a value."""
    rows = split_rows(name, split)
    if not has_parts(rows):
        return None
    low, high = ratio_range([row.ratio for row in rows if is_drawable(row.ratio)])
    marks = tuple((tick, f"{tick:,g}") for tick in ticks(low, high))
    names = tuple((LOWEST - row.place, row.label) for row in rows)
    return Chart(
        Axis(low, high, f"ratio; {BETTER[name]} is called better", marks, is_log=True),
        Axis(0.0, LOWEST + 0.9, "", names, has_grid=False),
        tuple(mark for row in rows for mark in _marks(row, low, high)),
        height=230.0,
    )


def _marks(row: SplitRow, low: float, high: float) -> Iterator[Mark]:
    """The interval under the point, the number above it; a word where there is no point."""
    place = LOWEST - row.place
    if not is_drawable(row.ratio) or row.ratio.value is None:
        yield Word(1.0, place, ratio_text(row.ratio), "start")
        return
    shape, _, is_open = row.symbol.partition("-")
    colour, ends = COLOURS[row.colour], interval_ends(row.ratio, low, high)
    if ends is not None:
        yield Line(list(ends), [place, place], colour)
    told = f"{row.label}: {ratio_text(row.ratio)} {interval_text(row.ratio)}"
    yield Dots([row.ratio.value], [place], colour, (told,), SHAPES[shape], bool(is_open), 4.5)
    yield Word(row.ratio.value, place, ratio_text(row.ratio), rise=13.0)
