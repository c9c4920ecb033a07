"""Any motion for algorithms with discrete actions."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.errors import UsageError
from harness.motion.motion import Motion, Move


@dataclass(frozen=True, eq=False)
class Discrete:
    """See `harness.motion.modes.DiscreteMode`. Choice 0 stays, 2 i + 1 and 2 i + 2 are minus and plus increment i."""

    inner: Motion

    @property
    def choices(self) -> int:
        """How many choices there are."""
        return 2 * len(self.inner.increments()) + 1

    @property
    def action_size(self) -> int:
        """Numbers in an action of the mode that is chosen from."""
        return self.inner.action_size

    @property
    def jumps(self) -> bool:
        """Whether the mode that is chosen from jumps."""
        return self.inner.jumps

    def decode(self, choices: NDArray[np.integer], qpos: Float) -> Float:
        """The actions that choices mean.

        Args:
            choices: (num_envs,), each at least 0 and less than `choices`.
            qpos: Joint targets of the last period, (num_envs, dof).

        Returns:
            (num_envs, action_size).

        Raises:
            UsageError: There is no such choice.
        """
        if not (np.min(choices) >= 0 and np.max(choices) < len(self._table)):
            raise UsageError(f"Discrete actions {choices}: choose from 0 to {self.choices - 1}")
        actions: Float = self.stay(qpos) + self._table[choices]
        return actions

    @cached_property
    def _table(self) -> Float:
        """What each choice adds to staying, (choices, action_size)."""
        increments = self.increments()
        both = np.stack([-increments, increments], axis=1).reshape(-1, self.action_size)
        return np.concatenate([np.zeros((1, self.action_size)), both])

    def advance(self, qpos: Float, qvel: Float, action: Float) -> Move:
        return self.inner.advance(qpos, qvel, action)

    def stay(self, qpos: Float) -> Float:
        """The action of the mode that is chosen from, with which an arm stays."""
        return self.inner.stay(qpos)

    def increments(self) -> Float:
        """Those of the mode that is chosen from."""
        return self.inner.increments()
