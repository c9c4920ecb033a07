"""A Gymnasium vector env in the form that stable-baselines3 takes."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from stable_baselines3.common.vec_env import VecEnv

from harness.algorithm import TrainingEnv


class VecEnvAdapter(VecEnv):
    """Passes a Gymnasium vector env to stable-baselines3.

    Both start the next episode in the step that ends one. They differ in how they report the end.
    """

    def __init__(self, env: TrainingEnv) -> None:
        self.env = env
        self._actions: Any = None
        super().__init__(env.num_envs, self._space(), env.single_action_space)

    def reset(self) -> Any:
        """First observations, (num_envs, observation_size)."""
        return self._seen(self.env.reset()[0])

    def step_async(self, actions: Any) -> None:
        """Keep the actions for `step_wait`."""
        self._actions = actions

    def step_wait(self) -> Any:
        """Observations, rewards, dones and one info per env."""
        observations, rewards, terminated, truncated, infos = self.env.step(self._actions)
        dones = terminated | truncated
        told: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for k in np.flatnonzero(dones):
            told[k] = {
                "terminal_observation": self._seen(infos["final_obs"][k]),
                "TimeLimit.truncated": bool(truncated[k] and not terminated[k]),
                "is_success": bool(infos["is_success"][k]),
            }
        return self._seen(observations), rewards.astype(np.float32), dones, told

    def close(self) -> None:
        """Does nothing: the env belongs to the caller."""

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """An attribute of the batch, once for each env."""
        return [getattr(self.env, attr_name)] * len(self._indices(indices))

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Not possible: no attribute differs between the envs of a batch.

        Raises:
            AttributeError: Always.
        """
        raise AttributeError(f"'{attr_name}' cannot be set through the adapter")

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> list[Any]:
        """The result of a method of the batch, once for each env."""
        return [getattr(self.env, method_name)(*args, **kwargs)] * len(self._indices(indices))

    def env_is_wrapped(self, wrapper_class: type, indices: Any = None) -> list[bool]:
        """False for each env."""
        return [False] * len(self._indices(indices))

    def _space(self) -> Any:
        """The space of one env's observations, as the library sees them."""
        return self.env.single_observation_space

    def _seen(self, observations: Any) -> Any:
        """Observations, (..., observation_size), as the library sees them."""
        return observations

    def _indices(self, indices: Any) -> Sequence[int]:
        return list(self._get_indices(indices))
