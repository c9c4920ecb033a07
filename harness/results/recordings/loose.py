"""Recordings that no experiment made, read as the done cells of a plan."""

from pathlib import Path

from harness.errors import UsageError
from harness.record.cell import EVALUATION_HORIZON, NO_ROBOT, NO_SIMULATOR, Cell
from harness.record.manifest import Manifest
from harness.record.plan_file import PLAN, StoredPlan
from harness.record.store import MOST_NAMED, Store
from harness.registry.choice import Choice
from harness.results.recordings.runs import Run, Runs, read_runs


class LooseStore(Store):
    """A folder in which recorded trainings lie, at any depth.

    Attributes:
        runs: The trainings.
    """

    def __init__(self, folder: Path) -> None:
        """Read all recordings.

        Raises:
            UsageError: There are none, none that can be compared, or whole experiments lie among them.
        """
        super().__init__(folder)
        _refuse_experiments(folder)
        self.runs: Runs = read_runs(folder)
        self._run_of = {self._cell(run): run for run in self.runs.members.values()}

    def read_plan(self) -> StoredPlan:
        """A plan of these trainings; the reward that was given first is the baseline."""
        return StoredPlan(self.runs.trained[0], False, {}, tuple(self._run_of), {})

    def examine(self, cell: Cell) -> Manifest:
        """All of them are done."""
        return Manifest(cell, status="done")

    def manifests(self) -> list[Manifest]:
        """The manifests of all trainings."""
        return list(map(self.examine, self._run_of))

    def cell_folder(self, cell: Cell) -> Path:
        """The folder of the recording."""
        return self._run_of[cell].path

    def _cell(self, run: Run) -> Cell:
        group = self.runs.group
        reward = Choice(run.reward, (), run.reward)
        return Cell(
            NO_SIMULATOR, NO_ROBOT, group.task, group.algorithm, reward, run.seed, group.steps,
            group.evaluation_episodes, evaluation_horizon=EVALUATION_HORIZON,
        )  # fmt: skip


def _refuse_experiments(folder: Path) -> None:
    """Check that no experiment lies in a folder: it has a plan of its own, and perhaps an arm's cells.

    Raises:
        UsageError: Experiments lie in it; they are named.
    """
    inside = sorted(path.parent for path in folder.rglob(PLAN) if Store.is_experiment(path.parent))
    if inside:
        named = ", ".join(f"'{path}'" for path in inside[:MOST_NAMED])
        raise UsageError(
            f"'{folder}' holds whole experiments, not only recorded trainings: {named}. "
            "Name an experiment itself, and move recordings that belong to none into a folder of their own"
        )
