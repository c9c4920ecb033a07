"""The recorded trainings of an experiment's cells, one study for each algorithm and environment."""

from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

from harness.errors import UsageError
from harness.eta.curve import Kind
from harness.record.cell import Cell
from harness.record.cell_folder import is_named
from harness.record.floor import Floor, floors_in
from harness.record.folder import RANDOM, recording_of
from harness.record.recording.recorded_training import recordings_in
from harness.results.comparison import Group
from harness.results.metrics import require_measures
from harness.results.recordings.read_runs import read_runs
from harness.results.recordings.runs import Runs
from harness.results.recordings.study import Study, compare_all
from harness.results.records import Records
from harness.results.seen import Seen


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

    def __repr__(self) -> str:
        return f"<PlaceStudy of {self.title}: {len(self.cells)} cells, {self.reason or repr(self.study)}>"

    def _repr_html_(self) -> str:
        """What a notebook shows: a line per comparison, or why there is none."""
        return f"<p>{escape(repr(self))}</p>" if self.study is None else self.study._repr_html_()

    @property
    def title(self) -> str:
        """The algorithm and the environment in which it trained."""
        return self.group.title

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        labels = {"task": self.group.task.label, "algorithm": self.group.algorithm.label, "steps": self.group.steps}
        study = self.study and self.study.to_json()
        return {**labels, "reason": self.reason, "notes": list(self.notes), "study": study}


def study_of_loose(
    folder: Path,
    runs: Runs,
    cells: Sequence[Cell],
    kind: Kind,
    shown: Sequence[str] | None = None,
    *,
    pairs: bool = False,
) -> PlaceStudy:
    """The study of recordings that lie loose.

    Args:
        folder: Where they lie.
        runs: All of them.
        cells: The same as cells.
        kind: Which curves I_N and I_P are read from; see `harness.eta.curve.GroupCurve`.
        shown: Which measures, beside the one that decides; all of them if None.
        pairs: Whether every two rewards are compared, and not each with the baseline alone.

    Raises:
        UsageError: A measure is not recorded.
    """
    if shown is not None:
        require_measures(shown, runs.measures)
        runs = runs.showing(shown)
    (study,) = compare_all(folder, [runs], kind, pairs=pairs)
    return PlaceStudy(runs.group, tuple(cells), study, "")


def studies_of(results: Records, shown: Sequence[str] | None = None) -> tuple[PlaceStudy, ...]:
    """The studies of an experiment whose task is an environment. A group without a done cell is left out.

    The questions of all studies are asked together.

    Raises:
        UsageError: A measure was chosen that no environment has.
    """
    read = {group: _runs_of(results, cells, results.named) for group, cells in results.groups.items()}
    compared = {group: runs for group, runs in read.items() if not isinstance(runs, str)}
    if compared and shown is not None:
        require_measures(shown, {name for runs in compared.values() for name in runs.measures})
        compared = {group: runs.showing(shown) for group, runs in compared.items()}
    terms, runs = results.plan.terms, list(compared.values())
    seen = Seen.of(results.manifests, terms.looks)
    found = compare_all(results.folder, runs, results.kind, terms, seen.look_of, seen.to_come, pairs=results.pairs)
    studies = dict(zip(compared, found, strict=True))
    return tuple(
        PlaceStudy(group, tuple(cells), studies[group], "")
        if group in studies
        else PlaceStudy(group, tuple(cells), None, str(read[group]), _notes(results, cells))
        for group, cells in results.groups.items()
    )


def _runs_of(results: Records, cells: Sequence[Cell], deciding: Sequence[str]) -> Runs | str:
    """The recorded trainings of cells; why there is nothing to compare where that is so."""
    trained, control = {cell.reward.label for cell in cells}, results.plan.control
    planned = {it.cell.reward.label for it in results.manifests if Group.of(it.cell) == Group.of(cells[0])}
    if len(trained) < 2 and not control and planned > trained:
        return f"nothing to compare: all done cells were trained with {cells[0].reward.label}"
    only = [path for cell in cells for path in _recordings_of(results, cell)]
    floor = floors_in(results.manifests, results.store).get(Floor.of(cells[0]))
    random = None if floor is None else results.store.cell_folder(floor) / recording_of(RANDOM)
    try:
        return read_runs(results.folder, only, results.baseline, deciding, Group.of(cells[0]), random, control)
    except UsageError as error:
        return str(error)


def _recordings_of(results: Records, cell: Cell) -> list[Path]:
    """Those that the cell itself left."""
    folder, done = results.store.cell_folder(cell), results.manifest(cell)
    return [path for path in sorted(recordings_in(folder)) if is_named(done, path.relative_to(folder).as_posix())]


def _notes(results: Records, cells: Sequence[Cell]) -> tuple[str, ...]:
    return tuple(f"{cell.title}: {note}" for cell in cells if (note := results.manifest(cell).note))
