"""The figure of a choice: what decides over the trainings, a line for each candidate that ends where it left."""

from collections.abc import Collection, Mapping

from harness.eta.headline import count_trainings
from harness.report.figures.chart import Axis, Chart, Dots, Line, Note, linear_axis, share_axis
from harness.report.rows.choosing import ChoosingTold

NAME = 0.075
"""The height of a name, as a share of the panel's."""
WIDE, NARROW = 2.5, 1.2


def draw_choosing(told: ChoosingTold) -> Chart:
    """Means over the trainings so far; those that have not left stand out."""
    lines, dots = [], []
    for name, points in told.points.items():
        if not points:
            continue
        seeds, means = [float(it) for it, _ in points], [value for _, value in points]
        colour = "proposed" if name in told.left else "baseline"
        lines.append(Line(seeds, means, colour, name, width=WIDE if name in told.left else NARROW))
        dots.append(Dots(seeds[-1:], means[-1:], colour, (f"{name} after {count_trainings(int(seeds[-1]))}",), size=4))
    ends = {_told(name, points[-1][0], told.left): points[-1][1] for name, points in told.points.items() if points}
    values = [value for points in told.points.values() for _, value in points]
    most = max((seeds for points in told.points.values() for seeds, _ in points), default=1)
    air = 0.04 * (max(values) - min(values)) or 0.5
    axis = (
        share_axis(told.measure) if told.is_share else linear_axis(min(values) - air, max(values) + air, told.measure)
    )
    return Chart(
        linear_axis(0.0, float(most), "trainings of each candidate in a place", 5),
        axis,
        (*lines, *dots, *_names(ends, axis)),
    )


def _told(name: str, seeds: int, left: Collection[str]) -> str:
    """A name, with the trainings after which it left: that tells its line from the others."""
    return name if name in left else f"{name}, left at {seeds}"


def _names(ends: Mapping[str, float], axis: Axis) -> list[Note]:
    """The names beside the ends of the lines, apart from one another."""
    gap, notes, below = NAME * (axis.high - axis.low), list[Note](), axis.high + axis.high - axis.low
    for name, value in sorted(ends.items(), key=lambda it: -it[1]):
        below = min(value, below - gap)
        notes.append(Note(below, name))
    return notes
