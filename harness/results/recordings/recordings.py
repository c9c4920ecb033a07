"""The recorded trainings of an experiment's cells in environments, or recordings that lie loose."""

from collections.abc import Iterable, Mapping
from functools import cached_property
from typing import Any

from harness.arrays import Float
from harness.errors import SchemaError
from harness.measure import Measure
from harness.record.cell import Cell
from harness.record.folder import TRAINING_RECORDING
from harness.record.manifest import Manifest
from harness.registry.choice import split_list
from harness.results.comparison import Comparison
from harness.results.frames import Frames, read_frames
from harness.results.measured import Measured, Moment
from harness.results.recordings.read_runs import LooseStore
from harness.results.recordings.recording_results import (
    RecordingResults,
    numbers_in_environment,
    numbers_of_part,
)
from harness.results.recordings.run_trainings import RunTrainings
from harness.results.recordings.runs import Run
from harness.results.recordings.study import PlaceStudy, studies_of, study_of_loose
from harness.results.records import Records
from harness.results.return_matrix import ReturnMatrix
from harness.results.table import Numbers


class Recordings:
    """What cells in an environment left."""

    subject = "agent"

    def __init__(self, records: Records, measures: Iterable[str] | str | None = None) -> None:
        """Read nothing yet.

        Args:
            records: What the folder says of its cells.
            measures: Which measures of the environment, beside the one that decides; all of them if None.
        """
        self.records, self._shown = records, None if measures is None else tuple(split_list(measures))

    @property
    def metrics(self) -> Mapping[str, Measure]:
        return {}

    @property
    def measures(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(name for it in self.trainings for name in it.names))

    @cached_property
    def studies(self) -> tuple[PlaceStudy, ...]:
        """The recorded trainings of each algorithm in each environment."""
        records, store = self.records, self.records.store
        if isinstance(store, LooseStore):
            given = (records.folder, store.runs, records.plan.cells, records.kind, self._shown)
            return (study_of_loose(*given, pairs=records.pairs),)
        return studies_of(records, self._shown)

    @property
    def trainings(self) -> list[RunTrainings]:
        """Those that are done, by group."""
        return [it.study.trainings for it in self.studies if it.study]

    @property
    def comparisons(self) -> list[Comparison]:
        """Those of all studies."""
        return [comparison for it in self.studies if it.study for comparison in it.study.comparisons]

    @property
    def notes(self) -> list[str]:
        told: dict[str, None] = {}
        several = len(self.studies) > 1
        for it in self.studies:
            lines = it.study.runs.notes if it.study else (it.reason, *it.notes)
            told |= dict.fromkeys(f"{it.title}: {line}" if several or not it.study else line for line in lines)
        return [*told]

    @property
    def said(self) -> list[str]:
        return [line for it in self.trainings for line in it.runs.said]

    @property
    def damaged(self) -> list[str]:
        return list(dict.fromkeys(line for it in self.trainings for line in it.runs.damaged))

    @property
    def returns(self) -> tuple[ReturnMatrix, ...]:
        """See `Results`; a matrix for each manner."""
        return tuple(
            ReturnMatrix(
                it.group,
                it.study.runs.trained,
                {
                    payer: {trained: table[payer, trained] for trained in it.study.runs.trained}
                    for payer in it.study.runs.rewards
                },
                {},
                manner,
            )
            for it in self.studies
            if it.study
            for manner, table in it.study.tables.items()
        )

    def examine(self, manifest: Manifest) -> Manifest:
        """The same: what is damaged is told when it is read."""
        return manifest

    def measured(self, cell: Cell) -> Measured:
        """Every measure of a done cell, by manner; none of a cell that is not compared with any other."""
        if cell.id not in self._run_of:
            return Measured({}, {}, {})
        run = self.run(cell)
        steps = next(it.study.runs.steps for it in self.studies if it.study and cell in it.cells)
        parts = run.parts(steps)
        random = next((it.study.runs.random for it in self.studies if it.study and cell in it.cells), None)
        return Measured(
            {manner: dict(part.behaviour) for manner, part in parts.items()},
            {manner: part.episodes for manner, part in parts.items()},
            dict(random.whole.behaviour) if random else {},
        )

    def moments(self, cell: Cell) -> tuple[Moment, ...]:
        return self.run(cell).moments(cell.steps)

    def recorded(self, cell: Cell) -> Float:
        files = self.records.store.cell_folder(cell)
        training = files / TRAINING_RECORDING
        return RecordingResults(self.records.folder, training if training.is_dir() else files).paid_by(
            cell.reward.label
        )

    def run(self, cell: Cell) -> Run:
        """The recorded training of a done cell.

        Raises:
            SchemaError: It is not compared with any other, and so was not read.
        """
        if cell.id not in self._run_of:
            raise SchemaError(f"cell {cell.id} is not compared with any other")
        return self._run_of[cell.id]

    @cached_property
    def _run_of(self) -> dict[str, Run]:
        """By id of the cell."""
        found: dict[str, Run] = {}
        for it in self.studies:
            runs = [] if it.study is None else [*it.study.runs.members.values(), *it.study.runs.control.values()]
            of = {(run.reward, run.seed): run for run in runs}
            found |= {cell.id: of[key] for cell in it.cells if (key := (cell.reward.label, cell.seed)) in of}
        return found

    def frames(self, cell: Cell, episode: int = 0) -> Frames | None:
        if not self.records.is_experiment:
            return Frames("recordings that no experiment made hold no policies, so no episode can be played again")
        return read_frames(self.records.folder, self.records.manifest(cell), episode)

    def older_keys(self) -> dict[str, Any]:
        """See `Results`: ``studies``; of recordings that lie loose the keys of the only one stand alone."""
        if isinstance(self.records.store, LooseStore):
            (it,) = self.studies
            return {} if it.study is None else it.study.to_json()
        return {"studies": [it.to_json() for it in self.studies]}

    def numbers(self, cell: Cell) -> Numbers:
        """See `Results`: means over the episodes of the final policy, else over those that say most about it."""
        if isinstance(self.records.store, LooseStore):
            run = self.run(cell)
            return numbers_of_part(next(iter(run.parts(run.steps).values())))
        return numbers_in_environment(self.records.folder, self.records.store.cell_folder(cell))
