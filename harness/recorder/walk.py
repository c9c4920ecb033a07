"""The states and actions of an episode, kept while an env is stepped."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import gymnasium
import numpy as np

from harness.recorder.recorder import kept

Observation = TypeVar("Observation")
Action = TypeVar("Action")


@dataclass(frozen=True, eq=False)
class Walk:
    """One episode.

    Attributes:
        states: What the env returned, steps + 1 of them: the one before the first step first.
        actions: One for each step, at least one.
    """

    states: Sequence[Any]
    actions: Sequence[Any]


class KeepWalks(gymnasium.Wrapper[Observation, Action, Observation, Action]):
    """Keeps copies of states and actions, of which arrays cannot be written into; changes nothing of the env.

    Attributes:
        walks: Of all episodes since the wrapper was made.
    """

    def __init__(self, env: gymnasium.Env[Observation, Action]) -> None:
        super().__init__(env)
        self.walks: list[Walk] = []
        self._states: list[Any] = []
        self._actions: list[Any] = []

    def reset(self, **options: Any) -> tuple[Observation, dict[str, Any]]:
        """Start an episode."""
        observation, info = self.env.reset(**options)
        self._states, self._actions = [_frozen(observation)], []
        return observation, info

    def step(self, action: Action) -> Any:
        """Take a step."""
        answer = self.env.step(action)
        self._states.append(_frozen(answer[0]))
        self._actions.append(_frozen(action))
        if len(self._actions) == 1:
            self.walks.append(Walk(self._states, self._actions))
        return answer


def _frozen(value: Any) -> Any:
    """A copy; a reward that writes into it is refused."""
    copied = kept(value)
    if isinstance(copied, np.ndarray):
        copied.setflags(write=False)
    return copied
