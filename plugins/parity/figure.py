"""The figures of a parity: how far apart tips and joints are over time, a line per pair."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from harness.arrays import Float
from harness.report.figures.chart import Axis, Chart, Line, linear_axis
from harness.report.figures.points import select_points

from .grids import pair_name, reference_pairs
from .parity import Pair, Parity

COLOURS = 7
"""The colours of the page's style sheet, ``pair-0`` and so on: apart for every kind of colour vision."""
DASHES = ("", "8 4", "2 3", "8 3 2 3", "14 4")
"""Lines of pairs may cover one another: each has its own dashes as well. Their number and the colours' share no
factor, so that all 35 combinations come."""
DECADES = 9
"""The logarithmic axis spans so many, at most: what is smaller counts for none."""


class Curve(NamedTuple):
    """What is drawn of every pair."""

    name: str
    factor: float
    """From its unit in the record to the drawn one."""
    label: str
    unit: str


TIPS = Curve("max_tip_error_m", 1e3, "distance of the tips [mm]", "mm")
JOINTS = Curve("max_joint_error_rad", math.degrees(1.0), "difference of a joint [deg]", "deg")


def draw_pairs(parity: Parity, curve: Curve) -> Chart:
    """The largest difference over all motions at each time, from the reference; without any, of all pairs."""
    lines = [line for pair, line in _lines(parity, curve) if pair in (reference_pairs(parity) or parity.pairs)]
    high = max((max(line.y) for line in lines), default=0.0) or 1.0
    return Chart(_time(lines), linear_axis(0.0, 1.04 * high, curve.label), tuple(lines))


def draw_all_pairs(parity: Parity, curve: Curve) -> Chart | None:
    """All pairs on a logarithmic axis, on which a difference of 0 has no place; None where there is no other."""
    lines = [line for _, line in _lines(parity, curve)]
    high = max((max(line.y) for line in lines), default=0.0)
    if high <= 0.0:
        return None
    least = min(value for line in lines for value in line.y if value > 0.0)
    first = max(math.floor(math.log10(least)), math.ceil(math.log10(high)) - DECADES)
    decades = range(first, math.ceil(math.log10(high)) + 1)
    ticks = tuple((10.0**decade, f"1e{decade}") for decade in decades)
    floor = 10.0**first
    drawn = [line._replace(y=[value if value >= floor else math.nan for value in line.y]) for line in lines]
    axis = Axis(floor, max(10.0 * floor, 10.0 ** decades[-1]), curve.label, ticks, is_log=True)
    return Chart(_time(lines), axis, tuple(drawn))


def _time(lines: Sequence[Line]) -> Axis:
    return linear_axis(0.0, max((line.x[-1] for line in lines), default=1.0) or 1.0, "time [s]")


def _lines(parity: Parity, curve: Curve) -> list[tuple[Pair, Line]]:
    return [
        (pair, _line(number, pair, parity.setting.period, curve.factor * pair.drift.curves()[curve.name]))
        for number, pair in enumerate(parity.pairs)
    ]


def _line(number: int, pair: Pair, period: float, values: Float) -> Line:
    points = select_points(values)
    colour, dash = f"pair-{number % COLOURS}", DASHES[number % len(DASHES)]
    return Line((points * period).tolist(), values[points].tolist(), colour, pair_name(pair), dash=dash, in_legend=True)
