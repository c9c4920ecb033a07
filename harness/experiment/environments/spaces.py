"""Observations and actions of policies in somebody's environment: flat numbers in, a box or a choice out."""

from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Dict, Discrete, flatdim, flatten

from harness.algorithm import ActionSpace
from harness.arrays import Float32
from harness.environment import AnyEnv
from harness.errors import UsageError
from harness.policy import Policy

MOST_NUMBERS = 1_000_000
"""The most numbers that an observation may have."""
ACHIEVED, DESIRED = "achieved_goal", "desired_goal"
"""Keys of observations that hold goals."""


def flat_observations(space: gymnasium.Space[Any]) -> Box:
    """The space of `flat_observation`, (observation_size,) of float32.

    Raises:
        UsageError: Observations of `space` have no fixed number of numbers, or too many.
    """
    try:
        size = flatdim(space)
    except (NotImplementedError, ValueError) as error:
        raise UsageError(f"its observations are {space}, which cannot be put into one row of numbers") from error
    if not 0 < size <= MOST_NUMBERS:
        raise UsageError(f"an observation has {size:,} numbers: 1 to {MOST_NUMBERS:,} are allowed")
    return Box(-np.inf, np.inf, (size,), np.float32)


def flat_observation(space: gymnasium.Space[Any], observation: Any) -> Float32:
    """An observation as one row of numbers, (observation_size,); a dict in the order of the space's keys."""
    flat: Float32 = np.asarray(flatten(space, observation), np.float32).ravel()
    return flat


def goal_columns(space: gymnasium.Space[Any]) -> tuple[slice, slice]:
    """The columns of the achieved and of the desired goal in a `flat_observation`.

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
        self._space, self._policy, self._type = env.observation_space, policy, env.action_space.dtype
        self._rng = rng

    def __call__(self, observation: Any) -> Any:
        """The action in the form that the env takes."""
        action = self._policy.act(flat_observation(self._space, observation)[np.newaxis], self._rng)[0]
        return int(action) if np.ndim(action) == 0 else np.asarray(action, self._type)
