"""Speeds as a terminal shows them."""

from rich.console import Group, RenderableType
from rich.text import Text

from harness.authoring.pages import show_grid

from .comparison import SpeedChanges, summary
from .speed_grids import comparison_grid, comparison_lines, left_out_lines, speed_grids
from .speeds import Speeds

STYLES = {"SLOWER": "bold red", "faster": "green"}


def speed_table(speeds: Speeds, comparison: SpeedChanges | None) -> RenderableType:
    """What ``harness bench simulators`` prints: the speeds, what has none, and last what became slower."""
    parts = [part for grid in speed_grids(speeds) for part in show_grid(grid)]
    parts += map(Text, left_out_lines(speeds))
    if comparison is not None:
        parts += show_grid(comparison_grid(comparison), STYLES)
        parts += [Text(), *map(Text, [*comparison_lines(comparison), *summary(comparison)])]
    return Group(*parts)
