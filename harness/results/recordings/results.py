"""The results of recorded trainings in environments: of an experiment's cells, or of recordings that lie loose."""

from collections.abc import Iterable, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

from harness.arrays import Float
from harness.errors import SchemaError
from harness.eta.curve import Kind
from harness.measure import Measure
from harness.record.cell import Cell
from harness.record.folder import TRAINING_RECORDING
from harness.record.store import Store
from harness.registry.choice import split_list
from harness.registry.registry import Registry
from harness.results.alone import Alone
from harness.results.comparison import Comparison
from harness.results.frames import Frames, read_frames
from harness.results.learning import Learning
from harness.results.measured import Measured, Moment
from harness.results.recordings.alone import alone_of
from harness.results.recordings.learning import learning_of
from harness.results.recordings.loose import LooseStore
from harness.results.recordings.places import PlaceStudy, studies_of, study_of_loose
from harness.results.recordings.recording_results import (
    RecordingResults,
    numbers_in_environment,
    numbers_of_part,
)
from harness.results.recordings.runs import Run
from harness.results.recordings.terms import terms_of_runs
from harness.results.results import Results
from harness.results.return_matrix import ReturnMatrix
from harness.results.table import Numbers
from harness.results.terms_paid import TermsPaid


class RecordedResults(Results):
    """Trainings whose steps were recorded, in any Gymnasium environment."""

    subject: ClassVar[str] = "agent"

    def __init__(
        self,
        folder: Path,
        registry: Registry,
        kind: Kind = "accumulated",
        *,
        metrics: Iterable[str] | None = None,
        is_temporary: bool = False,
        store: Store | None = None,
        pairs: bool = False,
    ) -> None:
        """Read the plan and all manifests; see `Results`.

        Args:
            folder: The folder of the experiment, or of the recordings.
            registry: The plugins.
            kind: Which curves the indices are read from.
            metrics: Which measures of the environment, beside the one that decides; all of them if None.
            is_temporary: Whether the folder is soon gone.
            store: Reads the folder; by default as that of an experiment.
            pairs: Whether every two rewards are compared, and not each with the baseline alone.
        """
        super().__init__(folder, registry, kind, is_temporary=is_temporary, store=store, pairs=pairs)
        self._shown = None if metrics is None else tuple(split_list(metrics))

    @property
    def metrics(self) -> Mapping[str, Measure]:
        """None: an environment has measures of its own, which its recordings hold."""
        return {}

    @property
    def measures(self) -> tuple[str, ...]:
        """The names of all measures of behaviour."""
        return tuple(dict.fromkeys(name for it in self.studies if it.study for name in it.study.runs.measures))

    @cached_property
    def studies(self) -> tuple[PlaceStudy, ...]:
        """The recorded trainings of each algorithm in each environment."""
        if isinstance(self.store, LooseStore):
            runs, cells = self.store.runs, self.plan.cells
            return (study_of_loose(self.folder, runs, cells, self.kind, self._shown, pairs=self.pairs),)
        return studies_of(self, self._shown)

    @cached_property
    def combinations(self) -> tuple[Comparison, ...]:
        """See `Results`; the null controls come last."""
        found = [comparison for it in self.studies if it.study for comparison in it.study.comparisons]
        return tuple(sorted(found, key=lambda it: it.is_control))

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """See `Results`."""
        told: dict[str, None] = {}
        several = len(self.studies) > 1
        for it in self.studies:
            lines = it.study.runs.notes if it.study else (it.reason, *it.notes)
            told |= dict.fromkeys(f"{it.title}: {line}" if several or not it.study else line for line in lines)
        return (*told, *self.damaged_recordings)

    @property
    def said(self) -> tuple[str, ...]:
        """See `Results`."""
        return tuple(line for it in self.studies if it.study for line in it.study.runs.said)

    @property
    def damaged_recordings(self) -> tuple[str, ...]:
        """Recordings that could not be read, a line each."""
        return tuple(dict.fromkeys(line for it in self.studies if it.study for line in it.study.runs.damaged))

    @cached_property
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

    @cached_property
    def terms(self) -> tuple[TermsPaid, ...]:
        """See `Results`."""
        return tuple(found for it in self.studies if it.study for found in terms_of_runs(it.study.runs))

    @cached_property
    def alone(self) -> tuple[Alone, ...]:
        """See `Results`."""
        found = (alone_of(it.study.runs) for it in self.studies if it.study)
        return tuple(it for it in found if it is not None)

    def learning(self, combination: Comparison) -> Learning | None:
        """See `Results`."""
        study = next(it.study for it in self.studies if it.study and combination in it.study.comparisons)
        return None if combination.is_control else learning_of(study.runs, combination)

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
        """See `Records`."""
        return self.run(cell).moments(cell.steps)

    def recorded(self, cell: Cell) -> Float:
        """See `Records`."""
        files = self.store.cell_folder(cell)
        training = files / TRAINING_RECORDING
        return RecordingResults(self.folder, training if training.is_dir() else files).paid_by(cell.reward.label)

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

    def frames(self, cell: Cell) -> Frames | None:
        """See `Results`."""
        if not self.is_experiment:
            return Frames("recordings that no experiment made hold no policies, so no episode can be played again")
        return read_frames(self.folder, self.manifest(cell))

    def older_keys(self) -> dict[str, Any]:
        """See `Results`: ``studies``; of recordings that lie loose the keys of the only one stand alone."""
        if isinstance(self.store, LooseStore):
            (it,) = self.studies
            return {} if it.study is None else it.study.to_json()
        return {"studies": [it.to_json() for it in self.studies]}

    def numbers(self, cell: Cell) -> Numbers:
        """See `Results`: means over the episodes of the final policy, else over those that say most about it."""
        if isinstance(self.store, LooseStore):
            run = self.run(cell)
            return numbers_of_part(next(iter(run.parts(run.steps).values())))
        return numbers_in_environment(self.folder, self.store.cell_folder(cell))
