"""What becomes of a cell's progress."""

import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from harness.experiment.attempt import Attempt
from harness.experiment.cell_evaluations import CellEvaluations
from harness.experiment.checkpoint import Checkpoint, store
from harness.experiment.event_log import EventLog
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
        events: EventLog,
    ) -> None:
        """Begin to count.

        Args:
            report: Told the steps.
            attempt: What the training starts with, and how often it leaves a checkpoint.
            env: Where it takes place; it stands where the attempt begins.
            parts: Its trace, which the env records.
            evaluations: Of its policy.
            events: Get the scalars.
        """
        self._report, self._attempt, self._env, self._parts = report, attempt, env, parts
        self._evaluations, self._events = evaluations, events
        self._last, self._since = attempt.begun_from, time.perf_counter()
        self._rings = attempt.checkpoint.rings if attempt.checkpoint else {}

    def __call__(self, steps: int) -> None:
        """See `harness.progress.Progress`."""
        self._report(steps)

    def policy(self, steps: int, make: "Callable[[], Policy]") -> None:
        """See `harness.progress.Progress`."""
        self._evaluations.offer(int(steps), make)

    def scalars(self, steps: int, values: Mapping[str, float]) -> None:
        """See `harness.progress.Progress`."""
        self._events.write(steps, values)

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
