"""The shaped reward of a batch: what it pays, and what it remembers of each episode."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from harness.arrays import Float, Mask
from harness.progress import TrainingState, prefixed
from harness.reward import Carry, Reward, Steps, pay, replace_where
from harness.reward.terms import require_same

NAME = "carry"
"""The name of the memory in a checkpoint."""


class Shaping:
    """A reward with what it remembers of each env's episode.

    Attributes:
        reward: What pays.
        carry: What it remembers; None before the first episode.
    """

    carry: Carry

    def __init__(self, reward: Reward, terms: Mapping[str, Float]) -> None:
        """Begin no episode yet.

        Args:
            reward: What pays.
            terms: By name, where what each of its terms pays is written, (num_envs, 1).
        """
        self.reward, self.carry = reward, None
        self._names = tuple(terms)
        self._columns = [(name, column[:, 0]) for name, column in terms.items()]

    def pay(self, steps: Steps) -> Float:
        """What a step pays, (num_envs,).

        Raises:
            UsageError: The reward pays other terms than at first.
        """
        self.carry, paid = pay(self.reward, self.carry, steps)
        if paid.terms or self._names:
            require_same(self._names, paid.terms)
            for name, column in self._columns:
                column[...] = paid.terms[name]
        shaped: Float = paid.total
        return shaped

    def restart(self, mask: Mask, begin_distance: Float) -> None:
        """Forget what was before in the envs of `mask`, whose targets are `begin_distance` away, (num_envs,)."""
        fresh = self.reward.initial_carry(begin_distance.copy())
        self.carry = fresh if self.carry is None else replace_where(mask, fresh, self.carry)

    def put_back(self, mask: Mask, carry: Carry) -> None:
        """Take over from `carry` the memory of the envs of `mask`."""
        self.carry = replace_where(~mask, self.carry, carry)

    def state(self) -> TrainingState:
        """Everything that `restore` needs."""
        return prefixed(NAME, dict(_leaves(self.carry)))

    def restore(self, state: Mapping[str, Any], begin_distance: Float) -> None:
        """Go on where `state` was told; the begin distances, (num_envs,), are those of then."""
        self.carry = _filled(self.reward.initial_carry(begin_distance.copy()), state, NAME)


def _leaves(carry: Carry, name: str = "") -> Iterator[tuple[str, Any]]:
    """The arrays of a reward's carry, by where they stand in it."""
    if isinstance(carry, tuple):
        for index, part in enumerate(carry):
            yield from _leaves(part, f"{name}.{index}")
    elif carry is not None:
        yield name, np.array(carry)


def _filled(fresh: Carry, state: Mapping[str, Any], name: str) -> Carry:
    """A carry of the form of `fresh` with the arrays that `_leaves` gave."""
    if isinstance(fresh, tuple):
        return tuple(_filled(part, state, f"{name}.{index}") for index, part in enumerate(fresh))
    return state[name].copy()
