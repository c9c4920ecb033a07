"""What becomes of a cell's progress."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from harness.experiment.attempt import Attempt
from harness.experiment.cell_evaluations import CellEvaluations
from harness.experiment.checkpoint import Checkpoint
from harness.experiment.event_log import EventLog
from harness.experiment.order import Report
from harness.experiment.trace_parts import TraceParts
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
        events: EventLog,
    ) -> None:
        """Put `env` where the attempt goes on, if it does.

        Args:
            report: Told the steps.
            attempt: What the training starts with, and how often it leaves a checkpoint.
            env: Where it takes place.
            parts: Its trace.
            evaluations: Of its policy.
            events: Get the scalars.
        """
        self._report, self._attempt, self._env, self._parts = report, attempt, env, parts
        self._evaluations, self._events = evaluations, events
        self._last = attempt.begun_from
        if attempt.checkpoint:
            env.restore(attempt.checkpoint.env)

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
        if not attempt.every or steps - self._last < attempt.every:
            return
        self._env.recorder = self._parts.cut()
        digests, seconds = tuple(self._parts.digests), attempt.seconds - self._evaluations.seconds
        Checkpoint(steps, attempt.origin, make(), self._env.state(), digests, seconds).write(attempt.folder)
        self._last = steps

    def restored(self) -> TrainingState | None:
        """See `harness.progress.Progress`."""
        checkpoint = self._attempt.checkpoint
        return checkpoint.algorithm if checkpoint else None
