"""The recorded trainings of an experiment's cells in environments, or recordings and logs that lie loose."""

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from types import MappingProxyType

from harness.arrays import Float
from harness.errors import SchemaError, UsageError
from harness.eta.manner import MANNERS
from harness.eta.seed_mean import SeedMean, mean_of_known
from harness.measure import Measure
from harness.record.cell import Cell
from harness.record.folder import RANDOM, TRAINING_RECORDING, recording_of
from harness.record.manifest import Manifest, is_named
from harness.record.recording.recorded_training import recordings_in
from harness.record.store import Floor, floors_in
from harness.registry.choice import split_list
from harness.results.comparison import Group
from harness.results.logs.told import Told
from harness.results.metrics import require_measures
from harness.results.recordings.read_runs import read_runs
from harness.results.recordings.recording_results import RecordingResults, numbers_in_environment, numbers_of_part
from harness.results.recordings.runs import Run, Runs
from harness.results.records import Records
from harness.results.return_matrix import ReturnMatrix
from harness.results.table import Numbers
from harness.results.trainings import Match, Trainings


class Recordings:
    """What cells in an environment left."""

    subject = "agent"
    metrics: Mapping[str, Measure] = MappingProxyType({})

    def __init__(self, records: Records, measures: Iterable[str] | str | None = None) -> None:
        """Read nothing yet.

        Args:
            records: What the folder says of its cells.
            measures: Which measures of the environment, beside the one that decides; all of them if None.
        """
        self.records, self._shown = records, None if measures is None else tuple(split_list(measures))

    def examine(self, manifest: Manifest) -> Manifest:
        """What there is to say of a cell: a recording is looked at as it is read."""
        return manifest

    def remove(self, cell: Cell) -> None:
        """Leave out a cell: one that is not done is not read."""

    @cached_property
    def read(self) -> dict[Group, tuple[Sequence[Cell], Runs | str]]:
        """The done cells of each group, with what they left; why there is nothing to compare where that is so.

        Raises:
            UsageError: A measure was chosen that no environment has.
        """
        records = self.records
        found: dict[Group, tuple[Sequence[Cell], Runs | str]] = (
            {records.runs.group: (records.plan.cells, records.runs)}
            if records.runs
            else {group: (cells, self._read(group, cells)) for group, cells in records.groups.items()}
        )
        known = [runs.measures for _, runs in found.values() if isinstance(runs, Runs)]
        if known and self._shown is not None:
            require_measures(self._shown, {name for names in known for name in names})
        return found

    def _trainings(self, runs: Runs) -> Trainings:
        records, deciding = self.records, runs.measures[:1]
        keys = [key for reward in runs.trained for key in sorted(runs.members) if key[0] == reward]
        return Trainings(
            runs.group,
            runs.trained[0],
            {key: runs.members[key] for key in keys},
            tuple(it for it in runs.measures if self._shown is None or it in {*deciding, *self._shown}),
            runs.measure,
            records.kind,
            deciding,
            deciding,
            next((name for name in deciding if runs.quantities[name].episodes), ""),
            records.plan.terms.averaged,
            runs.control,
            is_alone=len(runs.trained) == 1 and not runs.control,
            read=runs,
        )

    def _read(self, group: Group, cells: list[Cell]) -> Runs | str:
        """The recorded trainings of cells; why there is nothing to compare where that is so."""
        records = self.records
        trained, control = {cell.reward.label for cell in cells}, records.plan.control
        planned = {it.cell.reward.label for it in records.manifests if Group.of(it.cell) == group}
        if len(trained) < 2 and not control and planned > trained:
            return f"nothing to compare: all done cells were trained with {cells[0].reward.label}"
        only = [
            path
            for cell in cells
            for folder in (records.store.cell_folder(cell),)
            for path in sorted(recordings_in(folder))
            if is_named(records.manifest(cell), path.relative_to(folder).as_posix())
        ]
        floor = floors_in(records.manifests, records.store).get(Floor.of(cells[0]))
        random = None if floor is None else records.store.cell_folder(floor) / recording_of(RANDOM)
        try:
            return read_runs(
                records.folder, only, records.named, group, random, control, Told(baseline=records.baseline)
            )
        except UsageError as error:
            return str(error)

    @cached_property
    def trainings(self) -> list[Trainings]:
        """Those that are done, by group."""
        return [self._trainings(runs) for _, runs in self.read.values() if isinstance(runs, Runs)]

    @property
    def asked(self) -> list[tuple[Trainings, Match]]:
        """Each reward that taught with the baseline, or every two; the null control too."""
        return [(it, match) for it in self.trainings for match in it.matches(pairs=self.records.pairs)]

    @property
    def notes(self) -> tuple[str, ...]:
        """What to keep in mind of the trainings, a line each."""
        told: dict[str, None] = {}
        for group, (cells, runs) in self.read.items():
            if isinstance(runs, str):
                noted = (f"{it.title}: {note}" for it in cells if (note := self.records.manifest(it).note))
                lines, begin = (runs, *noted), f"{group.title}: "
            else:
                lines, begin = runs.notes, f"{group.title}: " * (len(self.read) > 1)
            told |= dict.fromkeys(f"{begin}{line}" for line in lines)
        return tuple(told)

    @property
    def returns(self) -> tuple[ReturnMatrix, ...]:
        """See `Results`; a matrix for each manner."""
        return tuple(matrix for it in self.trainings for matrix in _returns(it))

    def numbers(self, cell: Cell) -> Numbers:
        """See `Results`: means over the episodes of the final policy, else over those that say most about it."""
        if self.records.runs:
            run = self.run(cell)
            return numbers_of_part(next(iter(run.parts(run.steps).values())))
        return numbers_in_environment(self.records.folder, self.records.store.cell_folder(cell))

    def recorded(self, cell: Cell) -> Float:
        """See `Results`."""
        if self.records.runs:
            return self.run(cell).recorded.paid_by(cell.reward.label)
        training = self.records.store.cell_folder(cell) / TRAINING_RECORDING
        return RecordingResults(self.records.folder, training).paid_by(cell.reward.label)

    def run(self, cell: Cell) -> Run:
        """The recorded training of a done cell.

        Raises:
            SchemaError: It is not compared with any other, and so was not read.
        """
        if cell.id not in self.runs:
            raise SchemaError(f"cell {cell.id} is not compared with any other")
        return self.runs[cell.id]

    @cached_property
    def runs(self) -> dict[str, Run]:
        """The trainings that were read, those of the null control too, by id of the cell."""
        return {
            cell.id: run
            for cells, runs in self.read.values()
            if isinstance(runs, Runs)
            for of in ({it.key: it for it in (*runs.members.values(), *runs.control.values())},)
            for cell in cells
            if (run := of.get((cell.reward.label, cell.seed)))
        }


def _returns(trainings: Trainings) -> list[ReturnMatrix]:
    rewards = trainings.read.rewards if trainings.read else ()
    parts = {key: run.parts(run.cut) for key, run in trainings.runs.items() if isinstance(run, Run)}

    def mean(manner: str, payer: str, trained: str) -> SeedMean:
        of = [found.get(manner) for (reward, _), found in parts.items() if reward == trained]
        whys = (part.reasons.get(payer, "not recorded") for part in of if part and part.returns.get(payer) is None)
        paid = [part.returns.get(payer) if part else None for part in of]
        return mean_of_known(paid, f"seeds have none: {next(whys, 'not recorded')}")

    return [
        ReturnMatrix(
            trainings.group,
            tuple(trainings.rewards),
            {payer: {trained: mean(manner, payer, trained) for trained in trainings.rewards} for payer in rewards},
            {},
            manner,
        )
        for manner in MANNERS
        if any(manner in found for found in parts.values())
    ]
