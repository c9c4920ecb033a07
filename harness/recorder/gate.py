"""Stands at an env that a cell trains or evaluates in, inside of the recorder."""

from typing import Any

import gymnasium

from harness.reward.reward import is_finite, require_finite


class Gate(gymnasium.Wrapper[Any, Any, Any, Any]):
    """Raises SimulationDiverged for a number that is not finite, before the env, the recorder or a learner gets it."""

    def __init__(self, env: gymnasium.Env[Any, Any], where: str = "") -> None:
        """Begin before the first step; `where` follows the number of a step."""
        super().__init__(env)
        self._where, self._steps, self._take = where, 0, env.step

    def reset(self, **asked: Any) -> tuple[Any, dict[str, Any]]:
        """Start an episode."""
        observation, info = self.env.reset(**asked)
        self._require(observation=observation, info=info)
        return observation, info

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Take a step."""
        self._steps += 1
        if not is_finite(action):
            self._require(action=action)
        observation, pay, _, _, info = told = self._take(action)
        if not (is_finite(observation) and is_finite(pay) and (not info or is_finite(info))):
            self._require(observation=observation, pay=pay, info=info)
        return told

    def _require(self, **fields: Any) -> None:
        require_finite(fields, self._steps, self._where)
