"""What happens beside the training of a cell: its evaluations, its checkpoints, and what is told of it."""

import shutil
import time
import traceback
from collections.abc import Callable, Mapping
from pathlib import Path

from harness.executor import Word
from harness.experiment.checkpoints.checkpoint import Attempt, Checkpoint, store
from harness.experiment.workers.order import Report
from harness.experiment.world import CellWorld
from harness.policy import Policy
from harness.progress import Progress, TrainingState
from harness.record.cell import Cell
from harness.record.folder import EVALUATION, EVALUATIONS, LOG, RANDOM, evaluation_files, other_manner, recording_of
from harness.record.recording.facts import Acted


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
                shutil.rmtree(path) if path.is_dir() else path.unlink()
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
        self._evaluate(make(), partial, after=steps)
        partial.rename(path)  # so a killed process leaves no half-written evaluation under this name
        self.seconds += time.perf_counter() - clock

    def finish(self, policy: Policy, floor: bool) -> None:
        """Evaluate the trained policy, as the cell says and in the other manner; for a `floor` random actions too."""
        is_so, episodes = self._cell.deterministic, self._cell.evaluation_episodes
        self._evaluate(policy, self._named(EVALUATION))
        other: Acted = "stochastic" if is_so else "deterministic"
        self._world.evaluate(policy, other, episodes, self._named(other_manner(is_so)))
        if floor:
            self._world.evaluate(policy.floor(), "random", episodes, self._named(RANDOM))

    def _named(self, trace: str) -> Path:
        return self._folder / f"{recording_of(trace)}{self._world.suffix}"

    def _next_after(self, steps: int) -> int:
        every = self._cell.evaluate_every
        return (steps // every + 1) * every

    def _evaluate(self, policy: Policy, path: Path, after: int = 0) -> None:
        self._world.evaluate(policy, self._cell.acted, self._cell.evaluation_episodes, path, after=after)
        if not self._tracked:
            return
        try:
            scalars = self._world.scalars(path)
        except Exception:  # these numbers are only looked at, they change no result
            with (self._folder / LOG).open("a") as log:
                traceback.print_exc(file=log)
        else:
            self._report(Word(after or self._cell.steps, scalars))


SECONDS = 600.0
"""Seconds between two checkpoints, if no number of steps is given."""


class CellProgress(Progress):
    """Passes on steps and scalars to whoever watches, evaluates and writes checkpoints when they are due."""

    def __init__(
        self, report: Report, attempt: Attempt, world: CellWorld, evaluations: CellEvaluations, tracked: bool
    ) -> None:
        """Begin to count.

        Args:
            report: Told the steps and the scalars.
            attempt: What the training starts with, and how often it leaves a checkpoint.
            world: Where it takes place; it stands where the attempt begins.
            evaluations: Evaluates its policies.
            tracked: Whether what the algorithm tells is passed on.
        """
        self._report, self._attempt, self._world = report, attempt, world
        self._evaluations, self._tracked = evaluations, tracked
        self._last, self._since = attempt.begun_from, time.perf_counter()
        self._rings = attempt.checkpoint.rings if attempt.checkpoint else {}

    def __call__(self, steps: int) -> None:
        self._report(Word(int(steps), self._world.learned(int(steps), if_due=True)))

    def policy(self, steps: int, make: Callable[[], Policy]) -> None:
        self._evaluations.offer(int(steps), make)

    def scalars(self, steps: int, values: Mapping[str, float]) -> None:
        if self._tracked:
            self._report(Word(int(steps), {name: float(value) for name, value in values.items()}))

    def checkpoint(self, steps: int, make: Callable[[], TrainingState]) -> None:
        kept = self._world.kept() if self._is_due(steps) else None
        if kept is None:
            return
        (env, parts), attempt = kept, self._attempt
        seconds = attempt.seconds - self._evaluations.seconds
        stored = store(attempt.folder, make(), env, self._rings)
        Checkpoint(steps, attempt.origin, parts=tuple(parts), seconds=seconds, **stored).write(attempt.folder)
        self._last, self._since, self._rings = steps, time.perf_counter(), stored["rings"]

    def restored(self) -> TrainingState | None:
        checkpoint = self._attempt.checkpoint
        return checkpoint.restored(self._attempt.folder) if checkpoint else None

    def _is_due(self, steps: int) -> bool:
        every = self._attempt.every
        if every is None:
            return time.perf_counter() - self._since >= SECONDS
        return 0 < every <= steps - self._last
