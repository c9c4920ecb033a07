"""Speeds, and what changed, as grids that the terminal and the page share."""

from collections.abc import Sequence

from harness.authoring.pages import Grid

from .comparison import Change, SpeedChanges
from .entry import KINDS
from .speeds import Speed, Speeds, Spread, spread_of

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
