"""The recorded trainings of an experiment's cells, one study for each algorithm and environment."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from harness.errors import UsageError
from harness.record.cell import Cell
from harness.record.folder import EVALUATION_RECORDING, TRAINING_RECORDING
from harness.record.store import REPORT
from harness.results import Results
from harness.results.combination import Group
from harness.text import file_stems
from harness.trainings.study import Study, load_study


class PlaceStudy(NamedTuple):
    """The study of the done cells of one algorithm in one environment."""

    group: Group
    cells: tuple[Cell, ...]
    study: Study | None
    """The study; None if there is nothing to compare."""
    reason: str
    """Why there is no study; empty if there is one."""
    notes: tuple[str, ...] = ()
    """What to know of the cells where there is no study, which else says it: a line each."""

    @property
    def title(self) -> str:
        """The algorithm and the environment in which it trained."""
        return f"{self.group.task.label} · {self.group.algorithm.label}"


def studies_of(results: Results) -> tuple[PlaceStudy, ...]:
    """The studies of an experiment whose task is an environment. A group without a done cell is left out."""
    return tuple(_study(results, group, cells) for group, cells in results.groups.items())


def page_names(studies: Sequence[PlaceStudy], name: str = REPORT) -> list[str]:
    """A page for each study that compares something: `name`, or with several ``report-sac-fast.html``."""
    titles = [told.title for told in studies if told.study is not None]
    stem, _, ending = name.rpartition(".")
    return [name] if len(titles) == 1 else [f"{stem}-{part}.{ending}" for part in file_stems(titles)]


def _study(results: Results, group: Group, cells: Sequence[Cell]) -> PlaceStudy:
    folders = [results.store.cell_folder(cell) for cell in cells]
    only = [folder / part for folder in folders for part in (TRAINING_RECORDING, EVALUATION_RECORDING)]
    trained = list(dict.fromkeys(cell.reward.label for cell in cells))
    notes = tuple(f"{cell.title}: {note}" for cell in cells if (note := results.manifest(cell).note))
    if len(trained) < 2:
        reason = f"nothing to compare: all done cells were trained with {trained[0]}"
        return PlaceStudy(group, tuple(cells), None, reason, notes)
    try:
        told = results.plan.experiment.get("measure")  # a folder of anybody: whatever stands there
        deciding = [name for name in told if isinstance(name, str)] if isinstance(told, list) else []
        study = load_study(results.folder, results.kind, only, results.baseline, deciding)
    except UsageError as error:
        return PlaceStudy(group, tuple(cells), None, str(error), notes)
    named = replace(study, runs=study.runs._replace(env=group.task.label))
    return PlaceStudy(group, tuple(cells), named, "")
