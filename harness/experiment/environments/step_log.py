"""The calls that envs got since they were made, and a digest of their answers: enough to do all of it again.

The state of an env of anybody cannot be kept. But an env that draws whatever it draws from the generator that a seeded
reset gives it, as Gymnasium asks, does the same again when it is told the same.
"""

import hashlib
from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.errors import SchemaError
from harness.progress import Ring, TrainingState, as_state

FIRST_ROOM = 1024
"""The number of decisions for which there is room at the beginning."""


class StepLog:
    """A log that grows with every decision by an action of each env.

    Attributes:
        is_complete: False where they were reset in a way that the log does not hold.
    """

    def __init__(self) -> None:
        self.is_complete, self._has_begun = True, False
        self._actions: NDArray[Any] = np.empty((0, 0))
        self._decisions, self._resets = 0, list[int]()
        self._digest = hashlib.sha256()

    def note_reset(self, is_plain: bool) -> None:
        """Note a reset of all envs. The first reset has a seed, which is not noted; later ones have none."""
        self.is_complete &= is_plain == self._has_begun
        if self._has_begun:
            self._resets.append(self._decisions)
        self._has_begun = True

    def note_actions(self, actions: NDArray[Any]) -> None:
        """Note the actions of a decision, (num_envs, ...)."""
        if self._decisions == len(self._actions):
            grown = np.empty((max(FIRST_ROOM, 2 * self._decisions), *actions.shape), actions.dtype)
            grown[: self._decisions] = self._actions[: self._decisions] if self._decisions else 0
            self._actions = grown
        self._actions[self._decisions] = actions
        self._decisions += 1

    def note_answers(self, *answers: NDArray[Any]) -> None:
        """Note the envs' answers, which are arrays in row-major order."""
        for answer in answers:
            self._digest.update(answer.data)

    def state(self) -> TrainingState:
        """The whole log; see `actions_of`."""
        return as_state(
            {
                "actions": Ring({"actions": self._actions}, self._decisions),
                "resets": np.array(self._resets, np.int64),
                "digest": np.frombuffer(self._digest.digest(), np.uint8),
            }
        )

    def require_same(self, state: TrainingState) -> None:
        """Check that the envs gave the same answers when the calls were repeated.

        Raises:
            SchemaError: It was not.
        """
        if self._digest.digest() != np.asarray(state["digest"]).tobytes():
            raise SchemaError(
                "the environment did something else when the same actions were repeated: it depends on more than the "
                "seed that it is reset with"
            )


def actions_of(state: TrainingState) -> Iterator[NDArray[Any] | None]:
    """What the envs of a log were told, in order: actions, (num_envs, ...), or None for a reset without a seed."""
    ring, resets = state["actions"], Counter(np.asarray(state["resets"]).tolist())
    for decision in range(ring.written):
        yield from [None] * resets[decision]
        yield ring.columns["actions"][decision]
    yield from [None] * resets[ring.written]
