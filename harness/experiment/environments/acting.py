"""Lets a policy act in somebody's environment, on the observations of that environment."""

from typing import Any

import numpy as np

from harness.environment import AnyEnv
from harness.experiment.environments.spaces import flat_observation
from harness.policy import Policy


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
