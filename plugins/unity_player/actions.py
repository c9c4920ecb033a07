"""Actions of Unity's agents as Gymnasium's spaces, and back."""

import math
from typing import Any, TypeAlias

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Discrete

from .messages import Behaviour, UnityError

MOST_CHOICES = 1_024
"""The most choices of all branches together: algorithms choose among all combinations."""
Plain: TypeAlias = tuple[list[float], list[int]]
"""Continuous actions, and a choice in each discrete branch."""


def action_space(behaviour: Behaviour) -> gymnasium.Space[Any]:
    """A box of continuous actions, each in [-1, 1], or one choice: of the branch, or of a combination of all branches.

    Raises:
        UnityError: Agents have both kinds of actions, none, or too many choices.
    """
    if behaviour.continuous and behaviour.branches:
        raise UnityError(
            f"agents of the behaviour '{behaviour.name}' have {behaviour.continuous} continuous actions and "
            f"{len(behaviour.branches)} discrete branches: algorithms here take one kind. Set the other to 0 in Unity"
        )
    if behaviour.continuous:
        return Box(-1.0, 1.0, (behaviour.continuous,), np.float32)
    choices = math.prod(behaviour.branches)
    if not behaviour.branches or not 1 <= choices <= MOST_CHOICES:
        raise UnityError(
            f"agents of the behaviour '{behaviour.name}' have {len(behaviour.branches)} discrete branches with "
            f"{choices if behaviour.branches else 0:,} combinations: 1 to {MOST_CHOICES:,} are allowed"
        )
    return Discrete(choices)


def to_unity(behaviour: Behaviour, action: Any) -> Plain:
    """An action of `action_space` as Unity takes it; of a combination the last branch changes fastest."""
    if behaviour.continuous:
        return np.clip(np.asarray(action, np.float64), -1.0, 1.0).tolist(), []
    return [], [int(choice) for choice in np.unravel_index(int(action), behaviour.branches)]
