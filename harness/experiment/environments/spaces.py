"""Observations and actions of policies in somebody's environment: flat numbers in, a box or a choice out."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Dict, Discrete, Text, Tuple, flatdim, flatten
from numpy.typing import NDArray

from harness.algorithm import ActionSpace
from harness.arrays import Float32
from harness.environment import AnyEnv
from harness.errors import UsageError
from harness.policy import Policy

MOST_NUMBERS = 1_000_000
"""The most numbers that an observation may have."""
ACHIEVED, DESIRED = "achieved_goal", "desired_goal"
"""Keys of observations that hold goals."""


class Rows(NamedTuple):
    """What is observed as one row of numbers; text, sequences and graphs are left out."""

    size: int
    """How many numbers there are; 0 for none."""
    of: Callable[[Any], NDArray[Any]]
    """A row of an observation, (size,); a dict in the order of the space's keys."""

    def batch(self, observation: Any) -> Float32:
        """One observation as policies take them, (1, size)."""
        return np.asarray(self.of(observation), np.float32)[np.newaxis]


def rows_of(space: gymnasium.Space[Any]) -> Rows:
    """How observations of a space become rows."""
    if isinstance(space, Dict | Tuple):
        inner = space.spaces.items() if isinstance(space, Dict) else enumerate(space.spaces)
        parts = [(key, rows) for key, it in inner if (rows := rows_of(it)).size]
        if parts:
            return Rows(
                sum(rows.size for _, rows in parts),
                lambda seen: np.concatenate([rows.of(seen[key]) for key, rows in parts]),
            )
    if isinstance(space, Box):  # asked in every step: `flatten` looks for a function of the space each time
        return Rows(math.prod(space.shape), lambda seen: np.asarray(seen, space.dtype).flatten())
    try:
        size = 0 if isinstance(space, Text) else flatdim(space)
    except (NotImplementedError, ValueError):
        size = 0
    return Rows(size, (lambda seen: np.asarray(flatten(space, seen)).ravel()) if size else lambda seen: np.zeros(0))


def flat_observations(space: gymnasium.Space[Any]) -> Box:
    """The space of the rows, (observation_size,) of float32.

    Raises:
        UsageError: Observations of `space` have no fixed number of numbers, or too many.
    """
    size = rows_of(space).size
    if not 0 < size <= MOST_NUMBERS:
        raise UsageError(f"its observations are {space}, of {size:,} numbers: 1 to {MOST_NUMBERS:,} are allowed")
    return Box(-np.inf, np.inf, (size,), np.float32)


def goal_columns(space: gymnasium.Space[Any]) -> tuple[slice, slice]:
    """The columns of the achieved and of the desired goal in a row of `rows_of`.

    Raises:
        UsageError: Observations of `space` tell of no goals.
    """
    parts = space.spaces if isinstance(space, Dict) else {}
    shapes = [goal.shape for name in (ACHIEVED, DESIRED) if isinstance(goal := parts.get(name), Box)]
    if len(shapes) < 2 or shapes[0] != shapes[1] or len(shapes[0]) != 1:
        raise UsageError(
            f"observations have no goals: they would be a dict with {ACHIEVED} and {DESIRED}, two rows of as many "
            "numbers"
        )
    ends = np.cumsum([flatdim(part) for part in parts.values()]).tolist()
    columns = {name: slice(end - flatdim(part), end) for (name, part), end in zip(parts.items(), ends, strict=True)}
    return columns[ACHIEVED], columns[DESIRED]


def kind_of_actions(space: gymnasium.Space[Any]) -> ActionSpace:
    """Whether actions are continuous or discrete.

    Raises:
        UsageError: No algorithm takes such actions; says what can be done.
    """
    if isinstance(space, Discrete):
        if space.start != 0:
            raise UsageError(f"its actions are {space}: choices have to be counted from 0")
        return "discrete"
    if isinstance(space, Box) and np.issubdtype(space.dtype, np.floating) and len(space.shape) == 1:
        if not space.is_bounded():
            raise UsageError(
                f"its actions are {space}, without bounds: gymnasium.wrappers.RescaleAction gives them some"
            )
        return "continuous"
    raise UsageError(f"its actions are {space}: algorithms take a Discrete space, or a Box of one row of numbers")


def flat_actions(space: gymnasium.Space[Any]) -> gymnasium.Space[Any]:
    """The space of actions that algorithms see: the env's own, in float32 if actions are continuous."""
    return Box(space.low, space.high, space.shape, np.float32) if isinstance(space, Box) else space


class Acting:
    """Turns an observation into an action."""

    def __init__(self, env: AnyEnv, policy: Policy, rng: np.random.Generator | None = None) -> None:
        """Prepare to act.

        Args:
            env: That is acted in.
            policy: Of which spaces it has to have.
            rng: What it draws actions from; None if it takes the one action of each observation.
        """
        self._rows, self._policy, self._type = rows_of(env.observation_space), policy, env.action_space.dtype
        self._rng = rng

    def __call__(self, observation: Any) -> Any:
        """The action in the form that the env takes."""
        action = self._policy.act(self._rows.batch(observation), self._rng)[0]
        return int(action) if np.ndim(action) == 0 else np.asarray(action, self._type)
