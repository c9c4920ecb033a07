"""An experiment whose task is an environment, as a terminal shows it."""

from rich.console import Group, RenderableType
from rich.text import Text

from harness.report.rows.comparison import count_cells, remarks_on_cells
from harness.report.trainings.table import study_overview, study_table
from harness.results import Results


def environments_table(results: Results, command: str, details: bool = False) -> RenderableType:
    """The cells, and the overview or the full tables of every study.

    Args:
        results: The results of the experiment.
        command: The command that shows everything behind the overview.
        details: Whether to show the full tables.
    """
    parts: list[RenderableType] = [Text(count_cells(results)), *map(Text, remarks_on_cells(results))]
    for told in results.studies:
        parts += [Text(), Text(told.title, style="bold")]
        if told.study is None:
            parts += [Text(f"{line}.") for line in (told.reason, *told.notes)]
        else:
            parts.append(study_table(told.study, results) if details else study_overview(told.study, command, results))
    return Group(*parts)
