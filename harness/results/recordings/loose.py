"""Recordings that no experiment made, read as the done cells of a plan."""

from pathlib import Path

from harness.errors import UsageError
from harness.record.cell import BROUGHT, EVALUATION_HORIZON, Cell
from harness.record.manifest import Manifest
from harness.record.plan_file import StoredPlan
from harness.record.store import Store
from harness.registry.choice import Choice
from harness.results.recordings.read_runs import read_runs
from harness.results.recordings.runs import Run, Runs


class LooseStore(Store):
    """A folder in which recorded trainings lie, at any depth.

    Attributes:
        runs: The trainings.
    """

    def __init__(self, folder: Path, runs: Runs | None = None, baseline: str = "") -> None:
        """Read all recordings, unless they were read already.

        Args:
            folder: Where they lie.
            runs: What was read of them; None if nothing was.
            baseline: The reward that the others are compared with; by default the one that was given first.

        Raises:
            UsageError: There are none, none that can be compared, or whole experiments lie among them; or no training
                was taught by the baseline.
        """
        super().__init__(folder)
        self.runs: Runs = read_runs(folder, baseline=baseline) if runs is None else runs
        if baseline and baseline not in self.runs.trained:
            told = ", ".join(self.runs.trained)
            raise UsageError(f"--baseline {baseline}: no training was taught by it. There are: {told}")
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
            *BROUGHT, group.task, group.algorithm, reward, run.seed, group.steps,
            group.evaluation_episodes, evaluation_horizon=EVALUATION_HORIZON,
        )  # fmt: skip
