"""A race for the best reward, as a terminal shows it."""

from rich.console import RenderableType
from rich.text import Text

from harness.report.rows.race import RACE, RACE_TITLE, race_told
from harness.report.tables.grid import show_grid
from harness.results import Results


def race_lines(results: Results) -> list[RenderableType]:
    """The answer, and a line for each reward; none where there is no race, or no look is complete yet."""
    told = race_told(results)
    if told is None:
        return []
    return [
        Text(RACE_TITLE, style="bold"),
        Text(told.sentence, style="bold"),
        Text(),
        *show_grid(told.grid),
        *(part for line in told.beside for part in (Text(), Text(line))),
        Text(),
        Text(RACE, style="dim"),
    ]
