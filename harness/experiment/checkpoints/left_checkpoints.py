"""The checkpoints that a training leaves, one in place of the other."""

import time
from collections.abc import Sequence

from harness.experiment.checkpoints.attempt import Attempt
from harness.experiment.checkpoints.checkpoint import Checkpoint, store
from harness.progress import TrainingState

SECONDS = 600.0
"""From one checkpoint to the next, where nobody says how many steps."""


class LeftCheckpoints:
    """Knows when the next one is due, and what of a replay buffer is written already."""

    def __init__(self, attempt: Attempt) -> None:
        """Begin to count.

        Args:
            attempt: What the training starts with, and how often it leaves a checkpoint.
        """
        self._attempt = attempt
        self._last, self._since = attempt.begun_from, time.perf_counter()
        self._rings = attempt.checkpoint.rings if attempt.checkpoint else {}

    def is_due(self, steps: int) -> bool:
        """Whether one is, after so many environment steps."""
        every = self._attempt.every
        if every is None:
            return time.perf_counter() - self._since >= SECONDS
        return 0 < every <= steps - self._last

    def leave(
        self, steps: int, algorithm: TrainingState, env: TrainingState, seconds: float, parts: Sequence[str] = ()
    ) -> None:
        """Leave one; see `Checkpoint` for what the arguments are."""
        stored = store(self._attempt.folder, algorithm, env, self._rings)
        Checkpoint(steps, self._attempt.origin, parts=tuple(parts), seconds=seconds, **stored).write(
            self._attempt.folder
        )
        self._last, self._since, self._rings = steps, time.perf_counter(), stored["rings"]

    def restored(self) -> TrainingState | None:
        """What an algorithm needs to go on, where the training does."""
        checkpoint = self._attempt.checkpoint
        return checkpoint.restored(self._attempt.folder) if checkpoint else None
