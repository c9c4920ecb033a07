"""Lets a policy act in somebody's environment, on the observations of that environment."""

from typing import Any

import numpy as np

from harness.environment import AnyEnv
from harness.experiment.environments.spaces import flat_observation
from harness.policy import Policy
from harness.recorder.evaluate_policy import FIRST_SEED


class Acting:
    """Turns an observation into an action. A new object draws the same actions again, if it draws any."""

    def __init__(self, env: AnyEnv, policy: Policy, deterministic: bool) -> None:
        """Prepare to act.

        Args:
            env: That is acted in.
            policy: Of which spaces it has to have.
            deterministic: Whether it takes the action that it holds best, and draws none.
        """
        self._space, self._policy, self._type = env.observation_space, policy, env.action_space.dtype
        # What it draws depends on nothing that was drawn before.
        self._rng = None if deterministic else np.random.default_rng(FIRST_SEED)

    def __call__(self, observation: Any) -> Any:
        """The action in the form that the env takes."""
        action = self._policy.act(flat_observation(self._space, observation)[np.newaxis], self._rng)[0]
        return int(action) if np.ndim(action) == 0 else np.asarray(action, self._type)
