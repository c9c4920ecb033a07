"""Rankings as a terminal shows them."""

from rich.console import Group, RenderableType
from rich.text import Text

from harness.report.rows.ranking import AGREEMENT, CHOICE, EXPLANATION, TITLE, lines_of, task_rows, title_of
from harness.report.tables.grid import show_grid
from harness.results import Results
from harness.results.ranking import TaskRanking, ranking_of


def ranking_table(results: Results, details: bool) -> RenderableType | None:
    """The answer in each task, and on request what it rests on; None if there is nothing to compare."""
    tasks = ranking_of(results).tasks
    if not tasks:
        return None
    parts: list[RenderableType] = [Text(), Text(TITLE, style="bold")]
    for task in tasks:
        parts += [Text(title_of(task)), *(Text(f"  {line}") for line in lines_of(task))]
        parts += _tables(task) if details else []
    told = [Text(), Text(" ".join((EXPLANATION, CHOICE, AGREEMENT)), style="dim")] if details else []
    return Group(*parts, *told)


def _tables(task: TaskRanking) -> list[RenderableType]:
    rows = task_rows(task)
    grids = [*(table.grid for table in rows.ranks), rows.choices, rows.agreements]
    return [part for grid in grids for part in show_grid(grid)]
