"""Two groups of recorded runs compared, as a terminal shows it."""

from rich.console import Group, RenderableType
from rich.text import Text

from harness.report.rows import Grid
from harness.report.rows.ratios import index_grid, scales_text, split_grids, sum_grid
from harness.report.tables.grid import show_grid
from harness.score.compare import ComparedRuns

UNKNOWN = "an unknown reward"


def eta_table(comparison: ComparedRuns) -> RenderableType:
    """What ``harness eta`` prints: the number in words first, then what it rests on, as ``harness report`` shows it."""
    parts: list[RenderableType] = [
        Text(comparison_title(comparison), style="bold"),
        Text(runs_text(comparison)),
        *(Text(f"* {note}") for note in comparison.notes),
        Text(""),
        Text(comparison.number, style="bold"),
    ]
    for grid in grids_of(comparison, with_paths=False):
        parts += show_grid(grid)
    return Group(*parts, Text(f"\n{scales_text('robot')}"))


def grids_of(comparison: ComparedRuns, *, with_paths: bool) -> list[Grid]:
    """Every number, and on request both paths of every split."""
    found = comparison.decomposition
    return [*split_grids(found.splits, with_paths), sum_grid(found.total), index_grid(found, comparison.kind)]


def comparison_title(comparison: ComparedRuns) -> str:
    """Which rewards were compared, as far as they are known."""
    names = {who: name or UNKNOWN for who, name in comparison.rewards.items()}
    return f"proposed {names['proposed']} against {names['baseline']}"


def runs_text(comparison: ComparedRuns) -> str:
    """How many runs there are, and which part of them is not compared."""
    parts = []
    for who, count in comparison.runs.items():
        left_out = comparison.rows_left_out[who]
        cut = f" ({_count(left_out, 'row')} behind the shortest run left out)" if left_out else ""
        parts.append(f"{who} {_count(count, 'run')}{cut}")
    return ", ".join(parts) + (", event terms included" if comparison.with_events else "")


def _count(number: int, noun: str) -> str:
    return f"{number:,} {noun}" + "s" * (number != 1)
