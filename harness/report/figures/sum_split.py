"""The figure of ruler + behaviour: the change of a mean return and its parts, each with its interval."""

from harness.eta.seed_mean import SeedMean
from harness.eta.splits import SumSplit
from harness.report.figures.chart import Axis, Chart, Dots, Line, Mark, Note, Shape, linear_axis
from harness.report.rows.ratios import format_number, interval_text

ROWS: tuple[tuple[str, str, Shape], ...] = (
    ("change", "ink", "circle"),
    ("ruler", "ruler", "square"),
    ("behaviour", "behaviour", "diamond"),
)
"""Name, colour and shape of each part, from top to bottom."""


def draw_sum(split: SumSplit) -> Chart | None:
    """The figure of a change and its parts on one axis; None if not all of them are known."""
    parts = [getattr(split, name) for name, *_ in ROWS]
    ends = [end for part in parts for end in (part.mean, part.low, part.high) if end is not None]
    if any(part.mean is None for part in parts):
        return None
    low, high = min(0.0, *ends), max(0.0, *ends)
    air = 0.05 * (high - low) or 1.0
    axis = linear_axis(low - air, high + air, "return of an episode, proposed - baseline", 5)
    names = tuple((-float(place), name) for place, (name, *_) in enumerate(ROWS))
    zero: Mark = Line([0.0, 0.0], [-2.6, 0.6], "ink", width=1.0)
    marks = [mark for place, row in enumerate(ROWS) for mark in _marks(row, parts[place], -float(place))]
    return Chart(axis, Axis(-2.6, 0.6, "", names, has_grid=False), (zero, *marks), height=100.0)


def describe_sum(split: SumSplit) -> str:
    """The same in words."""
    change, ruler, behaviour = (format_number(it.mean) for it in (split.change, split.ruler, split.behaviour))
    return f"Change {change} = ruler {ruler} + behaviour {behaviour}."


def _marks(row: tuple[str, str, Shape], part: SeedMean, place: float) -> list[Mark]:
    name, colour, shape = row
    told = f"{format_number(part.mean)} {interval_text(part, '')}".rstrip()
    dots = Dots([part.mean or 0.0], [place], colour, (f"{name}: {told}",), shape, size=4.5)
    bar = [] if part.low is None or part.high is None else [Line([part.low, part.high], [place] * 2, colour)]
    return [*bar, dots, Note(place, told)]
