"""One agent of a program as a Gymnasium env."""

from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box

from harness import Float32

from .actions import action_space
from .team import Team


class AgentEnv(gymnasium.Env[Float32, Any]):
    """It steps from one decision of its agent to the next.

    Several envs of one team move together: each is told its action by `announce`, then each takes its step. An env that
    is alone needs no announcement. A step's reward is all that Unity paid since the last decision.

    Observations are all numbers of the agent's sensors behind one another, (observation_size,), without bounds.
    """

    metadata = {"render_modes": []}  # noqa: RUF012 # Gymnasium's own

    def __init__(self, team: Team, place: int) -> None:
        """Act in a place of a team.

        Raises:
            UnityError: Algorithms cannot choose such actions.
        """
        self._team, self._place, self._is_closed = team, place, False
        self.observation_space = Box(-np.inf, np.inf, (sum(team.behaviour.sizes),), np.float32)
        self.action_space = action_space(team.behaviour)
        team.open()

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Float32, dict[str, Any]]:
        """Start an episode."""
        super().reset(seed=seed)
        return self._team.begin(self._place, seed), {}

    def announce(self, action: Any) -> None:
        """Say what the next step does; see `harness.environment.announce_all`."""
        self._team.note(self._place, action)

    def step(self, action: Any) -> tuple[Float32, float, bool, bool, dict[str, Any]]:
        """Take one decision."""
        outcome = self._team.step(self._place, action)
        return *outcome, {"terminated": outcome.terminated, "paid": outcome.reward}

    def close(self) -> None:
        """End the program, unless other envs act in it."""
        if not self._is_closed:
            self._is_closed = True
            self._team.close()
