"""What becomes of a cell's progress."""

import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from harness.executor import Word
from harness.experiment.attempt import Attempt
from harness.experiment.cell_evaluations import CellEvaluations
from harness.experiment.checkpoint import Checkpoint, store
from harness.experiment.learning_so_far import LearningSoFar
from harness.experiment.order import Report
from harness.experiment.trace_parts import TraceParts
from harness.progress import Progress, TrainingState

if TYPE_CHECKING:
    from harness.env import ReachVectorEnv
    from harness.policy import Policy

SECONDS = 600.0
"""From one checkpoint to the next, where nobody says how many steps."""


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
        self._last, self._since = attempt.begun_from, time.perf_counter()
        self._rings = attempt.checkpoint.rings if attempt.checkpoint else {}

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
        attempt = self._attempt
        if not self._is_due(steps):
            return
        self._parts.cut()
        stored = store(attempt.folder, make(), self._rings)
        digests, seconds = tuple(self._parts.digests), attempt.seconds - self._evaluations.seconds
        Checkpoint(steps, attempt.origin, env=self._env.state(), parts=digests, seconds=seconds, **stored).write(
            attempt.folder
        )
        self._last, self._since, self._rings = steps, time.perf_counter(), stored["rings"]

    def restored(self) -> TrainingState | None:
        """See `harness.progress.Progress`."""
        checkpoint = self._attempt.checkpoint
        return checkpoint.restored(self._attempt.folder) if checkpoint else None

    def _is_due(self, steps: int) -> bool:
        every = self._attempt.every
        if every is None:
            return time.perf_counter() - self._since >= SECONDS
        return 0 < every <= steps - self._last
