"""What an experiment says whose task is an environment, as a terminal shows it."""

from collections.abc import Sequence

from rich.console import Group, RenderableType
from rich.text import Text

from harness.report.environments.studies import PlaceStudy
from harness.report.rows.comparison import count_cells, unfinished_cells
from harness.report.trainings.table import study_overview, study_table
from harness.results import Results


def environments_table(
    results: Results, studies: Sequence[PlaceStudy], command: str, details: bool = False
) -> RenderableType:
    """The cells, and every study: its overview, or all of it.

    Args:
        results: Of the experiment.
        studies: What its cells say.
        command: Shows all that the overview rests on.
        details: Whether to show all of it.
    """
    parts: list[RenderableType] = [Text(count_cells(results)), *map(Text, unfinished_cells(results))]
    for told in studies:
        parts += [Text(), Text(told.title, style="bold")]
        if told.study is None:
            parts.append(Text(f"{told.reason}."))
        else:
            parts.append(study_table(told.study) if details else study_overview(told.study, command))
    return Group(*parts)
