"""The replay buffer: one row per transition, so that a batch is one gather."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float32, Mask
from harness.progress import Ring


class Batch(NamedTuple):
    """Transitions drawn from the buffer: views of one array, valid until the next draw.

    The inputs have the form that the networks take: action, observation and a 1 side by side for the critics, the same
    without the action for the actor. The learner overwrites the actions with those that the actor would take.
    """

    inputs: Float32
    """Before the decision and after it, (2, rows, action_size + observation_size + 1); after it the action is empty."""
    reward: Float32
    """What the decision was paid, (rows,)."""
    goes_on: Float32
    """0 where the decision terminated the episode, else 1, (rows,)."""


class Replay:
    """The last `capacity` transitions, in float32."""

    def __init__(self, capacity: int, observation_size: int, action_size: int) -> None:
        """Allocate room for all of them. The operating system provides the memory only when it is written."""
        self._action_size, self._width = action_size, action_size + observation_size + 1
        self._rows = np.empty((capacity, 2 * self._width + 2), np.float32)
        self._drawn = np.empty((0, 0), np.float32)
        self._written = self._next = self.size = 0

    def add(
        self,
        observation: Float32,
        action: Float32,
        following: Float32,
        reward: NDArray[np.floating],
        terminated: Mask,
    ) -> None:
        """Keep a decision of every env. If the buffer is full, it forgets the oldest transitions.

        Args:
            observation: What was observed before the decision, (num_envs, observation_size).
            action: The decision, (num_envs, action_size).
            following: What was observed after it, (num_envs, observation_size).
            reward: What it was paid, (num_envs,).
            terminated: Whether it terminated the episode, (num_envs,).
        """
        a, w, count = self._action_size, self._width, len(self._rows)
        where = np.arange(self._next, self._next + len(observation)) % count
        row = np.ones((len(observation), self._rows.shape[1]), np.float32)
        row[:, :a], row[:, a : w - 1] = action, observation
        row[:, w : w + a], row[:, w + a : 2 * w - 1] = 0.0, following
        row[:, -2], row[:, -1] = reward, ~terminated
        self._rows[where] = row
        self._next = (self._next + len(observation)) % count
        self.size = min(self.size + len(observation), count)
        self._written += len(observation)

    def ring(self) -> Ring:
        """The transitions in the buffer, for `restore`."""
        return Ring({"rows": self._rows}, self._written)

    def restore(self, ring: Ring) -> None:
        """Take over the transitions of the buffer that returned `ring`."""
        ring.copy_into({"rows": self._rows})
        self._written, self._next = ring.written, ring.written % len(self._rows)
        self.size = min(ring.written, len(self._rows))

    def draw(self, rows: int, rng: np.random.Generator) -> Batch:
        """Draw `rows` transitions, each with equal probability from those in the buffer."""
        if len(self._drawn) != rows:
            self._drawn = np.empty((rows, self._rows.shape[1]), np.float32)
        # "clip" clips nothing here: it is the mode that writes into `out` without a copy
        np.take(self._rows, rng.integers(0, self.size, rows), axis=0, out=self._drawn, mode="clip")
        inputs = self._drawn[:, :-2].reshape(rows, 2, self._width).swapaxes(0, 1)
        return Batch(inputs, self._drawn[:, -2], self._drawn[:, -1])
