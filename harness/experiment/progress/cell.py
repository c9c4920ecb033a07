"""Passes on the progress of a cell."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from harness.executor import Word
from harness.experiment.checkpoints.attempt import Attempt
from harness.experiment.checkpoints.left_checkpoints import LeftCheckpoints
from harness.experiment.evaluation.cell import CellEvaluations
from harness.experiment.workers.order import Report
from harness.experiment.world import CellWorld
from harness.progress import Progress, TrainingState

if TYPE_CHECKING:
    from harness.policy import Policy


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
        self._checkpoints = LeftCheckpoints(attempt)

    def __call__(self, steps: int) -> None:
        """See `harness.progress.Progress`."""
        self._report(Word(int(steps), self._world.learned(int(steps), if_due=True)))

    def policy(self, steps: int, make: "Callable[[], Policy]") -> None:
        """See `harness.progress.Progress`."""
        self._evaluations.offer(int(steps), make)

    def scalars(self, steps: int, values: Mapping[str, float]) -> None:
        """See `harness.progress.Progress`."""
        if self._tracked:
            self._report(Word(int(steps), {name: float(value) for name, value in values.items()}))

    def checkpoint(self, steps: int, make: Callable[[], TrainingState]) -> None:
        """See `harness.progress.Progress`."""
        if not self._checkpoints.is_due(steps):
            return
        kept = self._world.kept()
        if kept is not None:
            state, parts = kept
            seconds = self._attempt.seconds - self._evaluations.seconds
            self._checkpoints.leave(steps, make(), state, seconds, parts)

    def restored(self) -> TrainingState | None:
        """See `harness.progress.Progress`."""
        return self._checkpoints.restored()
