"""The steps for which two rewards pay most differently."""

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from harness.record.recording.recorded_training import RecordedTraining

MOST = 3
"""So many steps are told of each pair."""
LEAST = 0.1
"""Standard deviations; steps that are paid less differently are not told."""


@dataclass(frozen=True)
class StepApart:
    """A step for which two rewards pay very differently.

    Attributes:
        folder: The recording.
        env: Number of the env in it.
        episode: Counted from 0 in that env.
        step: Counted from 0 in that episode.
        paid: By both.
        deviations: The same in standard deviations from the mean of each reward, over the steps of that recording.
    """

    folder: str
    env: int
    episode: int
    step: int
    paid: tuple[float, float]
    deviations: tuple[float, float]

    @property
    def difference(self) -> float:
        """The difference of the deviations, never negative."""
        return abs(self.deviations[0] - self.deviations[1])

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return asdict(self)


def steps_apart(folder: str, recording: "RecordedTraining", one: str, other: str) -> list[StepApart]:
    """The steps of a recording with the largest differences, largest first, one of an episode at most.

    None where a reward pays all steps the same.
    """
    values = np.stack([recording.rewards[one], recording.rewards[other]])
    spread = values.std(axis=1, keepdims=True)
    if not (spread > 1e-9 * np.abs(values).max(axis=1, keepdims=True)).all():
        return []
    deviations = (values - values.mean(axis=1, keepdims=True)) / spread
    difference = np.abs(deviations[0] - deviations[1])
    falling = np.argsort(-difference, kind="stable")
    most = int(recording.episode.max()) + 1
    _, first = np.unique(recording.env[falling].astype(np.int64) * most + recording.episode[falling], return_index=True)
    largest = falling[np.sort(first)[:MOST]]
    return [
        StepApart(
            folder,
            int(recording.env[row]),
            int(recording.episode[row]),
            int(recording.step[row]),
            (float(values[0, row]), float(values[1, row])),
            (float(deviations[0, row]), float(deviations[1, row])),
        )
        for row in largest[difference[largest] >= LEAST]
    ]
