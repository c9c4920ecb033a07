"""A race for the best reward, as a terminal shows it."""

from collections.abc import Sequence

from rich.console import Group, RenderableType
from rich.text import Text

from harness.report.rows.comparison import count_cells, remarks_on_cells
from harness.report.rows.race import EXPLANATION, TITLE, race_told
from harness.report.tables.grid import show_grid
from harness.results import Results


def race_table(results: Results, left_out: Sequence[str] = ()) -> RenderableType | None:
    """The answer, a line for each reward, and the cells; None where there is no race.

    Args:
        results: The experiment.
        left_out: Why candidates are missing, a line each.
    """
    told = race_told(results)
    if told is None:
        return None
    parts: list[RenderableType] = [Text(TITLE, style="bold"), Text(told.sentence, style="bold"), Text()]
    parts += [
        *show_grid(told.grid),
        *map(Text, left_out),
        Text(EXPLANATION, style="dim"),
        Text(),
        Text(count_cells(results), style="bold"),
    ]
    return Group(*parts, *map(Text, remarks_on_cells(results)))
