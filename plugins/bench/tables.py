"""Speeds, and what changed, as a terminal shows them and as one HTML file that opens anywhere, offline."""

from collections.abc import Sequence
from pathlib import Path

from rich.console import Group, RenderableType
from rich.text import Text

from harness.authoring.pages import (
    Axis,
    Chart,
    Dots,
    Grid,
    Line,
    Mark,
    draw_chart,
    render_page,
    show_grid,
    ticks,
    write_page,
)

from .contests import KINDS
from .speeds import Change, Speed, SpeedChanges, Speeds, Spread, spread_of, summary

MICRO = 1e6
TITLES = {
    "simulators": "Simulators beside their bare engines",
    "algorithms": "Algorithms beside their bare libraries",
    "peers": "Beside what others have",
}
SHARED = (
    "us per step is CPU time of an environment step. Speed is how many times as fast as the reference of the same line."
)


def speed_grids(speeds: Speeds) -> list[Grid]:
    """A grid for each kind of entry that there is."""
    grids = []
    for kind in KINDS:
        rows = [row for speed in speeds.speeds if speed.entry.kind == kind for row in _rows(speed)]
        if rows:
            headings = ("", "us per step", "reference", "us per step", "speed", "middle half")
            grids.append(Grid(headings, rows, [], TITLES[kind]))
    if grids:
        rounds = f"Medians of {speeds.rounds} rounds" if speeds.rounds > 1 else "One round"
        grids[-1].notes.extend([SHARED, f"{rounds}, each in a process of its own, in turns. {speeds.cpu}."])
    return grids


def _rows(speed: Speed) -> list[tuple[str, ...]]:
    reference = speed.reference
    beside = (reference, _micro(speed.seconds[reference])) if reference else ("none", "")
    return [
        (name_of(speed.entry.title, name), _micro(seconds), *beside, *_spread(speed.speeds.get(name)))
        for name, seconds in speed.seconds.items()
        if name != reference
    ]


def name_of(title: str, contender: str) -> str:
    """What a line is called: an entry of one contender by its title alone."""
    return title if contender == title else f"{title}: {contender}"


def _spread(values: Sequence[float] | None) -> tuple[str, str]:
    if values is None:
        return "", ""
    found: Spread = spread_of(values)
    return f"{found.median:.2f}", f"{found.low:.2f} to {found.high:.2f}"


def _micro(seconds: float) -> str:
    return f"{MICRO * seconds:,.1f}"


def comparison_grid(comparison: SpeedChanges) -> Grid:
    """Every line of both runs: its speed then and now, what changed, and what noise explains."""
    rows: list[tuple[str, ...]] = [
        (
            name_of(change.title, change.contender),
            f"{spread_of(change.old).median:.2f}",
            f"{spread_of(change.new).median:.2f}",
            f"{change.ratio - 1.0:+.1%}",
            f"{1.0 - change.noise:.1%}",
            _word(change),
        )
        for change in comparison.changes
    ]
    return Grid(("", "speed before", "speed now", "change", "noise", ""), rows, [], "Compared with the earlier run")


def _word(change: Change) -> str:
    if change.is_slower:
        return "SLOWER"
    return "faster" if change.is_faster else "same"


def left_out_lines(speeds: Speeds) -> list[str]:
    """A line for whatever has no numbers."""
    told = [("failed", *each) for each in speeds.failed] + [("left out", *each) for each in speeds.left_out]
    return [f"{word}: {name}: {reason}" for word, name, reason in told]


def comparison_lines(comparison: SpeedChanges) -> list[str]:
    """What differs beside the plugins, and what only the earlier run has."""
    missing = [f"not compared: {title}: only the earlier run has it" for title in comparison.missing]
    return [*comparison.remarks, *missing]


STYLES = {"SLOWER": "bold red", "faster": "green"}


def speed_table(speeds: Speeds, comparison: SpeedChanges | None) -> RenderableType:
    """What ``harness bench simulators`` prints: the speeds, what has none, and last what became slower."""
    parts = [part for grid in speed_grids(speeds) for part in show_grid(grid)]
    parts += map(Text, left_out_lines(speeds))
    if comparison is not None:
        parts += show_grid(comparison_grid(comparison), STYLES)
        parts += [Text(), *map(Text, [*comparison_lines(comparison), *summary(comparison)])]
    return Group(*parts)


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
