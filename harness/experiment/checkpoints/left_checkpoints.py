"""The checkpoints that a training leaves, one in place of the other."""

import time
from collections.abc import Sequence

from harness.experiment.checkpoints.attempt import Attempt
from harness.experiment.checkpoints.checkpoint import Checkpoint, store
from harness.progress import TrainingState

SECONDS = 600.0
"""Seconds between two checkpoints, if no number of steps is given."""


class LeftCheckpoints:
    """Writes checkpoints when they are due. It knows which rows of a replay buffer are written already."""

    def __init__(self, attempt: Attempt) -> None:
        """Begin to count.

        Args:
            attempt: What the training starts with, and how often it leaves a checkpoint.
        """
        self._attempt = attempt
        self._last, self._since = attempt.begun_from, time.perf_counter()
        self._rings = attempt.checkpoint.rings if attempt.checkpoint else {}

    def is_due(self, steps: int) -> bool:
        """Whether a checkpoint is due after `steps` environment steps."""
        every = self._attempt.every
        if every is None:
            return time.perf_counter() - self._since >= SECONDS
        return 0 < every <= steps - self._last

    def leave(
        self, steps: int, algorithm: TrainingState, env: TrainingState, seconds: float, parts: Sequence[str] = ()
    ) -> None:
        """Write a checkpoint; see `Checkpoint` for the arguments."""
        stored = store(self._attempt.folder, algorithm, env, self._rings)
        Checkpoint(steps, self._attempt.origin, parts=tuple(parts), seconds=seconds, **stored).write(
            self._attempt.folder
        )
        self._last, self._since, self._rings = steps, time.perf_counter(), stored["rings"]

    def restored(self) -> TrainingState | None:
        """What an algorithm needs to go on; None if the training begins anew."""
        checkpoint = self._attempt.checkpoint
        return checkpoint.restored(self._attempt.folder) if checkpoint else None
