"""The states and actions of an episode, kept while an env is stepped."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import gymnasium

from harness.recorder.sealed import Sealer

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
    """Keeps copies of states and actions, which nobody can write into; changes nothing of the env.

    Attributes:
        walks: Of all episodes since the wrapper was made.
    """

    def __init__(self, env: gymnasium.Env[Observation, Action]) -> None:
        super().__init__(env)
        self.walks: list[Walk] = []
        self._seal = Sealer().seal
        self._states: list[Any] = []
        self._actions: list[Any] = []

    def reset(self, **options: Any) -> tuple[Observation, dict[str, Any]]:
        """Start an episode."""
        observation, info = self.env.reset(**options)
        self._states, self._actions = [self._seal(observation)], []
        return observation, info

    def step(self, action: Action) -> Any:
        """Take a step."""
        answer = self.env.step(action)
        self._states.append(self._seal(answer[0]))
        self._actions.append(self._seal(action))
        if len(self._actions) == 1:
            self.walks.append(Walk(self._states, self._actions))
        return answer
