"""A parity as a terminal shows it, and as one HTML file that opens anywhere, offline."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from rich.console import Group, RenderableType
from rich.text import Text

from harness.arrays import Float
from harness.authoring.pages import (
    Axis,
    Chart,
    Line,
    draw_chart,
    linear_axis,
    render_page,
    select_points,
    show_grid,
    write_page,
)

from .grids import (
    class_grid,
    classes_text,
    contact_text,
    engines_text,
    failures,
    not_installed,
    pair_grids,
    pair_name,
    reference_pairs,
    response_grid,
    setting_text,
    simulator_grid,
    title,
    verdict,
)
from .parity import Pair, Parity

COLOURS = 7
"""The colours of the page's style sheet, ``pair-0`` and so on: apart for every kind of colour vision."""
DASHES = ("", "8 4", "2 3", "8 3 2 3", "14 4")
"""Lines of pairs may cover one another: each has its own dashes as well. Their number and the colours' share no
factor, so that all 35 combinations come."""
DECADES = 9
"""The logarithmic axis spans so many, at most: what is smaller counts for none."""
TEMPLATE = Path(__file__).parent / "parity.html.j2"
TOLD = "how far two simulators are apart over time. The tables have the largest values."


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


def write_parity(parity: Parity, path: Path) -> None:
    """Write figures and tables to `path`.

    Raises:
        UsageError: A library of the extra ``report`` is missing, or `path` cannot be written.
    """
    curves = [("Tips", TIPS), ("Joints", JOINTS)] if parity.pairs else []
    everything = [(heading, draw_all_pairs(parity, curve)) for heading, curve in curves]
    grids = [grid for grid in (*pair_grids(parity), simulator_grid(parity)) if grid.rows]
    first = reference_pairs(parity) or list(parity.pairs)
    rest = [pair for pair in parity.pairs if pair not in first]
    folded = [grid for grid in (class_grid(parity, rest), response_grid(parity)) if grid.rows]
    page = render_page(
        TEMPLATE,
        "--html",
        title=title(parity),
        setting=setting_text(parity),
        verdict=verdict(parity),
        contact=contact_text(parity),
        engines=engines_text(parity),
        panels=[(heading, draw_chart(draw_pairs(parity, curve), f"{heading}: {TOLD}")) for heading, curve in curves],
        all_panels=[(heading, draw_chart(chart, f"{heading}: {TOLD}")) for heading, chart in everything if chart],
        grids=grids,
        classes=classes_text(parity) if first else "",
        by_class=class_grid(parity, first),
        by_class_too=folded if first else [],
        failures=failures(parity),
        not_installed=not_installed(parity),
    )
    write_page(page, path, "The page")


def parity_table(parity: Parity) -> RenderableType:
    """What ``harness parity`` prints: the pairs first, the reference's before the others'."""
    contact = contact_text(parity)
    parts: list[RenderableType] = [
        Text(title(parity), style="bold"),
        Text(f"{setting_text(parity)}\n"),
        Text(verdict(parity), style="bold"),
        *([Text(contact, style="bold")] if contact else []),
        Text(engines_text(parity)),
    ]
    for grid in (*pair_grids(parity), simulator_grid(parity)):
        parts += show_grid(grid)
    if parity.pairs:
        parts += [Text(), Text("By class of motions", style="bold"), Text(classes_text(parity))]
        parts += show_grid(class_grid(parity, reference_pairs(parity) or list(parity.pairs)))
    told = [*failures(parity), *not_installed(parity)]
    return Group(*parts, *([Text()] if told else []), *map(Text, told))
