"""The evaluations of one cell: while it trains, every so many steps, and at the end."""

import shutil
import time
import traceback
from collections.abc import Callable
from pathlib import Path

from harness.executor import Word
from harness.experiment.checkpoints.attempt import Attempt
from harness.experiment.workers.order import Report
from harness.experiment.world import CellWorld
from harness.policy import Policy
from harness.record.cell import Cell
from harness.record.folder import EVALUATION, EVALUATIONS, LOG, RANDOM, evaluation_files, other_manner, recording_of


class CellEvaluations:
    """Evaluates policies of a cell in envs of their own, so that the training does not change.

    Attributes:
        seconds: What the evaluations took during training.
    """

    def __init__(self, cell: Cell, world: CellWorld, attempt: Attempt, tracked: bool, report: Report) -> None:
        """Go on after the last evaluation that the attempt's checkpoint knows of; later ones are made again.

        Args:
            cell: The cell whose policies are evaluated.
            world: The cell's.
            attempt: Where the training begins.
            tracked: Whether the results are passed on.
            report: Told the results.
        """
        self._cell, self._world, self._report, self._tracked = cell, world, report, tracked
        self._folder = attempt.folder
        self.seconds = 0.0
        self._due = cell.evaluate_every
        for steps, path in evaluation_files(self._folder, world.suffix).items():
            if steps > attempt.begun_from:
                _remove(path)
            else:
                self._due = self._next_after(steps)

    def offer(self, steps: int, make: Callable[[], Policy]) -> None:
        """Evaluate what `make` gives if an evaluation is due after `steps`; the one at the end is `finish`'s."""
        if not self._cell.evaluate_every or not self._due <= steps < self._cell.steps:
            return
        clock = time.perf_counter()
        self._due = self._next_after(steps)
        path = self._folder / EVALUATIONS / f"{steps}{self._world.suffix}"
        path.parent.mkdir(exist_ok=True)
        partial = path.with_name(f".{path.name}")
        self._evaluate(steps, make(), partial, after=steps)
        partial.rename(path)  # so a killed process leaves no half-written evaluation under this name
        self.seconds += time.perf_counter() - clock

    def finish(self, policy: Policy, floor: bool) -> None:
        """Evaluate the trained policy, as the cell says and in the other manner; for a `floor` random actions too."""
        deterministic = self._cell.deterministic
        self._evaluate(self._cell.steps, policy, self._named(EVALUATION))
        self._world.record(policy, not deterministic, self._named(other_manner(deterministic)), after=0)
        if floor:
            self._world.record_random(policy, self._named(RANDOM))

    def _named(self, trace: str) -> Path:
        return self._folder / f"{recording_of(trace)}{self._world.suffix}"

    def _next_after(self, steps: int) -> int:
        every = self._cell.evaluate_every
        return (steps // every + 1) * every

    def _evaluate(self, steps: int, policy: Policy, path: Path, after: int = 0) -> None:
        self._world.record(policy, self._cell.deterministic, path, after)
        if not self._tracked:
            return
        try:
            scalars = self._world.scalars(path)
        except Exception:  # these numbers are only looked at, they change no result
            with (self._folder / LOG).open("a") as log:
                traceback.print_exc(file=log)
        else:
            self._report(Word(steps, scalars))


def _remove(path: Path) -> None:
    shutil.rmtree(path) if path.is_dir() else path.unlink()
