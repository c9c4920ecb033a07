"""The steps for which two rewards pay most differently."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from harness.log import REWARD, Log

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


def steps_apart(folder: str, log: Log, one: str, other: str) -> list[StepApart]:
    """The steps of a log without start rows with the largest differences, largest first, one of an episode at most.

    None where a reward pays all steps the same.
    """
    values = np.stack([log[f"{REWARD}{one}"], log[f"{REWARD}{other}"]])
    spread = values.std(axis=1, keepdims=True)
    if not (spread > 1e-9 * np.abs(values).max(axis=1, keepdims=True)).all():
        return []
    deviations = (values - values.mean(axis=1, keepdims=True)) / spread
    difference = np.abs(deviations[0] - deviations[1])
    found: dict[tuple[int, int], StepApart] = {}  # by env and episode
    for row in np.argsort(-difference, kind="stable"):
        if len(found) == MOST or difference[row] < LEAST:
            break
        env, episode, step = (int(log[name][row]) if name in log else 0 for name in ("env", "episode", "step"))
        (first, second), (first_from, second_from) = values[:, row].tolist(), deviations[:, row].tolist()
        apart = StepApart(folder, env, episode, step, (first, second), (first_from, second_from))
        found.setdefault((env, episode), apart)
    return list(found.values())
