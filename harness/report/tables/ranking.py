"""Rankings as a terminal shows them."""

from rich.console import Group, RenderableType
from rich.text import Text

from harness.report.rows.ranking import AGREEMENT, CHOICE, EXPLANATION, TITLE, task_rows
from harness.report.tables.grid import show_grid
from harness.results import Results
from harness.results.ranking import ranking_of


def ranking_table(results: Results, details: bool) -> RenderableType | None:
    """The answer in each task, and on request what it rests on; None if there is nothing to compare."""
    tasks = ranking_of(results).tasks
    if not tasks:
        return None
    parts: list[RenderableType] = [Text(), Text(TITLE, style="bold")]
    for rows in map(task_rows, tasks):
        parts += [Text(rows.title), *(Text(f"  {line}") for line in rows.lines)]
        grids = [*(table.grid for table in rows.ranks), rows.choices, rows.agreements] if details else []
        parts += [part for grid in grids for part in show_grid(grid)]
    told = [Text(), Text(" ".join((EXPLANATION, CHOICE, AGREEMENT)), style="dim")] if details else []
    return Group(*parts, *told)
