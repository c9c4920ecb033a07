"""Passes on the progress of a cell."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from harness.executor import Word
from harness.experiment.checkpoints.attempt import Attempt
from harness.experiment.checkpoints.left_checkpoints import LeftCheckpoints
from harness.experiment.checkpoints.trace_parts import TraceParts
from harness.experiment.evaluation.cell import CellEvaluations
from harness.experiment.progress.learning_so_far import LearningSoFar
from harness.experiment.workers.order import Report
from harness.progress import Progress, TrainingState

if TYPE_CHECKING:
    from harness.env import ReachVectorEnv
    from harness.policy import Policy


class CellProgress(Progress):
    """Passes on steps and scalars to whoever watches, evaluates and writes checkpoints when they are due."""

    def __init__(
        self,
        report: Report,
        attempt: Attempt,
        env: "ReachVectorEnv",
        parts: TraceParts,
        evaluations: CellEvaluations,
        learning: LearningSoFar,
        tracked: bool,
    ) -> None:
        """Begin to count.

        Args:
            report: Told the steps and the scalars.
            attempt: What the training starts with, and how often it leaves a checkpoint.
            env: Where it takes place; it stands where the attempt begins.
            parts: Its trace, which the env records.
            evaluations: Of its policy.
            learning: What the episodes come to.
            tracked: Whether what the algorithm tells is passed on.
        """
        self._report, self._attempt, self._env, self._parts = report, attempt, env, parts
        self._evaluations, self._learning, self._tracked = evaluations, learning, tracked
        self._checkpoints = LeftCheckpoints(attempt)

    def __call__(self, steps: int) -> None:
        """See `harness.progress.Progress`."""
        self._report(Word(int(steps), self._learning.scalars_if_due(int(steps))))

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
        self._parts.cut()
        seconds = self._attempt.seconds - self._evaluations.seconds
        self._checkpoints.leave(steps, make(), self._env.state(), seconds, self._parts.digests)

    def restored(self) -> TrainingState | None:
        """See `harness.progress.Progress`."""
        return self._checkpoints.restored()
