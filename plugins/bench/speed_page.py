"""Speeds as one HTML file that opens anywhere, offline."""

from pathlib import Path

from harness.authoring.pages import Axis, Chart, Dots, Line, Mark, draw_chart, render_page, ticks, write_page

from .comparison import SpeedChanges, summary
from .speed_grids import comparison_grid, comparison_lines, left_out_lines, name_of, speed_grids
from .speeds import Speeds, spread_of

TEMPLATE = Path(__file__).parent / "speed.html.j2"
LABEL = "How many times as fast as its reference each line is. The tables have the numbers."
ROW = 24.0
"""Height of a line of the figure, [px]."""


def write_speed_page(speeds: Speeds, comparison: SpeedChanges | None, path: Path) -> None:
    """Write figure and tables to `path`.

    Args:
        speeds: What was measured.
        comparison: With an earlier run, where there is one.
        path: The file.

    Raises:
        UsageError: A library of the extra ``report`` is missing, or `path` cannot be written.
    """
    chart = draw_speeds(speeds, comparison)
    page = render_page(
        TEMPLATE,
        "--html",
        title="How fast the plugins are",
        verdict=summary(comparison) if comparison else [],
        lines=[*(comparison_lines(comparison) if comparison else []), *left_out_lines(speeds)],
        figure=draw_chart(chart, LABEL) if chart else "",
        grids=[*([comparison_grid(comparison)] if comparison and comparison.changes else []), *speed_grids(speeds)],
    )
    write_page(page, path, "The page")


def draw_speeds(speeds: Speeds, comparison: SpeedChanges | None) -> Chart | None:
    """A row per line: median and middle half of the rounds; those of the earlier run below it. None if empty."""
    now = [
        (name_of(speed.entry.title, name), values) for speed in speeds.speeds for name, values in speed.speeds.items()
    ]
    before = {
        name_of(change.title, change.contender): change.old for change in (comparison.changes if comparison else ())
    }
    if not now:
        return None
    every = [value for _, values in now for value in values] + [value for old in before.values() for value in old]
    low, high = min([0.9, *every]) / 1.1, max([1.1, *every]) * 1.1
    rows = {name: float(len(now) - place) for place, (name, _) in enumerate(now)}
    y = Axis(0.3, len(now) + 0.7, "", tuple((row, name) for name, row in rows.items()), has_grid=False)
    x = Axis(low, high, "times as fast as the reference", tuple((tick, f"{tick:g}") for tick in ticks(low, high)), True)
    marks = _marks([(rows[name] + 0.12, values) for name, values in now], "baseline", "now")
    if before:
        marks = _marks([(rows[name] - 0.22, old) for name, old in before.items()], "random", "before") + marks
    return Chart(x, y, marks, height=ROW * len(now) + 12.0)


def _marks(rows: list[tuple[float, tuple[float, ...]]], colour: str, legend: str) -> tuple[Mark, ...]:
    spreads = [(row, spread_of(values)) for row, values in rows]
    bars = [Line([spread.low, spread.high], [row, row], colour) for row, spread in spreads]
    names = tuple(
        f"{legend}: {spread.median:.3f}, middle half {spread.low:.3f} to {spread.high:.3f}" for _, spread in spreads
    )
    dots = Dots([spread.median for _, spread in spreads], [row for row, _ in spreads], colour, names, legend=legend)
    return (*bars, dots)
