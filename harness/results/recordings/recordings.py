"""The recorded trainings of an experiment's cells in environments, or recordings and logs that lie loose."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from types import MappingProxyType

from harness.arrays import Float
from harness.errors import UsageError
from harness.eta.index import SeedMean, mean_of_known
from harness.eta.manner import MANNERS
from harness.measure import Measure
from harness.record.cell import BROUGHT, EVALUATION_HORIZON, Cell
from harness.record.folder import EVALUATION_RECORDING, RANDOM, TRAINING_RECORDING, recording_of
from harness.record.manifest import Manifest, is_named
from harness.record.plan_file import StoredPlan
from harness.record.recording.facts import FILE_BEHAVIOUR
from harness.record.recording.recorded_training import recordings_in
from harness.record.store import floors_in
from harness.registry.choice import Choice, split_list
from harness.results.comparison import Group
from harness.results.frames import Frames, read_frames
from harness.results.logs.told import Told
from harness.results.metrics import require_measures
from harness.results.recordings.episodes import Part
from harness.results.recordings.read_runs import read_runs
from harness.results.recordings.recording_results import RecordingResults
from harness.results.recordings.runs import Run, Runs
from harness.results.results import Results
from harness.results.return_matrix import ReturnMatrix
from harness.results.table import Numbers
from harness.results.trainings import Trainings

RETURN = "return_"
"""What the columns of mean returns begin with."""


class Recordings(Results):
    """What cells in an environment left, or recordings and logs that no experiment made."""

    subject, in_environment = "agent", True
    metrics: Mapping[str, Measure] = MappingProxyType({})

    @property
    def _shown(self) -> Sequence[str] | None:
        """Measures of the environment that were chosen, beside the one that decides; None for all."""
        return None if self._chosen is None else split_list(self._chosen)

    @cached_property
    def read(self) -> dict[Group, tuple[Sequence[Cell], Runs | str]]:
        """The done cells of each group, with what they left; why there is nothing to compare where that is so.

        Raises:
            UsageError: A measure was chosen that no environment has.
        """
        found: dict[Group, tuple[Sequence[Cell], Runs | str]] = (
            {self.loose.group: (self.plan.cells, self.loose)}
            if self.loose
            else {group: (cells, self._runs_of(group, cells)) for group, cells in self.groups.items()}
        )
        known = [runs.measures for _, runs in found.values() if isinstance(runs, Runs)]
        if known and self._shown is not None:
            require_measures(self._shown, {name for names in known for name in names})
        return found

    def _trainings(self, runs: Runs) -> Trainings:
        deciding = runs.measures[:1]
        keys = [key for reward in runs.trained for key in sorted(runs.members) if key[0] == reward]
        return Trainings(
            runs.group,
            runs.trained[0],
            {key: runs.members[key] for key in keys},
            tuple(it for it in runs.measures if self._shown is None or it in {*deciding, *runs.offered, *self._shown}),
            runs.measure,
            self.kind,
            deciding,
            deciding,
            next((name for name in deciding if runs.quantities[name].episodes), ""),
            self.plan.terms.averaged,
            runs.control,
            is_alone=len(runs.trained) == 1 and not runs.control,
            read=runs,
        )

    def _runs_of(self, group: Group, cells: list[Cell]) -> Runs | str:
        """The recorded trainings of cells; why there is nothing to compare where that is so."""
        trained, control = {cell.reward.label for cell in cells}, self.plan.control
        planned = {it.cell.reward.label for it in self.manifests if Group.of(it.cell) == group}
        is_choosing = bool(self.plan.terms.budget)
        if len(trained) < 2 and not control and planned > trained and not is_choosing:
            return f"nothing to compare: all done cells were trained with {cells[0].reward.label}"
        only = [
            path
            for cell in cells
            for folder in (self.store.cell_folder(cell),)
            for path in sorted(recordings_in(folder))
            if is_named(self.manifest(cell), path.relative_to(folder).as_posix())
        ]
        floor = floors_in(self.manifests, self.store).get(cells[0].floor)
        random = None if floor is None else self.store.cell_folder(floor) / recording_of(RANDOM)
        # Where one of several rewards is chosen, the baseline trains last.
        baseline = self.baseline if self.baseline in trained or not is_choosing else ""
        try:
            return read_runs(self.folder, only, self.named, group, random, control, Told(baseline=baseline))
        except UsageError as error:
            return str(error)

    @cached_property
    def trainings(self) -> list[Trainings]:
        return [self._trainings(runs) for _, runs in self.read.values() if isinstance(runs, Runs)]

    def _lines(self) -> Iterable[str]:
        told: dict[str, None] = {}
        for group, (cells, runs) in self.read.items():
            if isinstance(runs, str):
                noted = (f"{it.title}: {note}" for it in cells if (note := self.manifest(it).note))
                lines, begin = (runs, *noted), f"{group.title}: "
            else:
                lines, begin = runs.notes, f"{group.title}: " * (len(self.read) > 1)
            told |= dict.fromkeys(f"{begin}{line}" for line in lines)
        return told

    def _matrices(self) -> Iterator[ReturnMatrix]:
        """See `Results`; one for each manner."""
        return (matrix for it in self.trainings for matrix in _returns(it))

    def numbers(self, cell: Cell) -> Numbers:
        """See `Results`: means over the episodes of the final policy, else over those that say most about it."""
        if self.loose:
            run = self.runs[cell.id]
            return numbers_of_part(next(iter(run.parts(run.steps).values())))
        return numbers_in_environment(self.folder, self.store.cell_folder(cell))

    def recorded(self, cell: Cell) -> Float:
        if self.loose:
            return self.runs[cell.id].recorded.paid_by(cell.reward.label)
        training = self.store.cell_folder(cell) / TRAINING_RECORDING
        return RecordingResults(self.folder, training).paid_by(cell.reward.label)

    def frames(self, cell: Cell, episode: int = 0) -> Frames:
        if self.loose:
            return Frames("recordings that no experiment made hold no policies, so no episode can be played again")
        return read_frames(self.folder, self.manifest(cell), episode)

    def _examine(self, cell: Cell) -> Manifest:
        return Manifest(cell, status="done") if self.loose else super()._examine(cell)

    def run(self, cell: Cell) -> Run | None:
        return self.runs.get(cell.id)

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


def plan_of(runs: Runs) -> StoredPlan:
    """A plan of trainings that no experiment made; the reward that was given first is the baseline."""
    group = runs.group
    cells = (
        Cell(
            *BROUGHT, group.task, group.algorithm, Choice(reward, (), reward), seed, group.steps,
            group.evaluation_episodes, evaluation_horizon=EVALUATION_HORIZON,
        )
        for reward, seed in runs.members
    )  # fmt: skip
    return StoredPlan(runs.trained[0], False, {}, tuple(cells), {})


def numbers_in_environment(folder: Path, files: Path) -> Numbers:
    """What the final policy of a cell in an environment did, and what every reward paid for it: means over episodes.

    Args:
        folder: The experiment's.
        files: The cell's.

    Raises:
        SchemaError: The recording of its evaluation is damaged.
    """
    found = RecordingResults(folder, files / EVALUATION_RECORDING)
    part = found.episodes.part(0, found.steps)
    found.keep()
    return numbers_of_part(part)


def numbers_of_part(part: Part) -> Numbers:
    """Measures and mean returns of some episodes, by the columns that they have in a table of cells."""
    did = {f"{FILE_BEHAVIOUR}{name}": value for name, value in part.behaviour.items()}
    return Numbers({**did, **{f"{RETURN}{name}": value for name, value in part.returns.items()}}, part.reasons)
