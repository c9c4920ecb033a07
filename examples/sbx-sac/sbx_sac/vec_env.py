"""The harness's env as stable-baselines3 wants it, and a callback that tells how the training goes."""

from collections.abc import Callable
from typing import Any

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv

from harness.env import ReachVectorEnv
from harness.policy import Policy
from harness.progress import TOLD_EVERY, Progress


class Adapter(VecEnv):
    """Both start the next episode in the step that ends one; they differ in how they tell."""

    def __init__(self, env: ReachVectorEnv) -> None:
        self.env = env
        self._actions: Any = None
        super().__init__(env.num_envs, env.single_observation_space, env.single_action_space)

    def reset(self) -> Any:
        """First observations, without a seed: the env has its own."""
        return self.env.reset()[0]

    def step_async(self, actions: Any) -> None:
        """Keep the actions for `step_wait`."""
        self._actions = actions

    def step_wait(self) -> Any:
        """Observations, rewards, dones, and where an episode ended what was seen last."""
        seen, rewards, terminated, truncated, infos = self.env.step(self._actions)
        dones = terminated | truncated
        told: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for k in np.flatnonzero(dones):
            told[k] = {
                "terminal_observation": infos["final_obs"][k],
                "TimeLimit.truncated": bool(truncated[k] and not terminated[k]),
            }
        return seen, rewards.astype(np.float32), dones, told

    def close(self) -> None:
        """The env belongs to whoever made it."""

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """The same for every env."""
        return [getattr(self.env, attr_name)] * self.num_envs

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Nothing can be set for some of the envs."""
        raise AttributeError(attr_name)

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> list[Any]:
        """The method of the whole batch."""
        return [getattr(self.env, method_name)(*args, **kwargs)] * self.num_envs

    def env_is_wrapped(self, wrapper_class: type, indices: Any = None) -> list[bool]:
        """No env is."""
        return [False] * self.num_envs


class Tell(BaseCallback):
    """Tells environment steps, of which a decision may take several, and ends the training at its budget."""

    def __init__(self, env: ReachVectorEnv, budget: int, progress: Progress, make: Callable[[Any], Policy]) -> None:
        super().__init__()
        self._env, self._budget, self._progress, self._make = env, budget, progress, make
        self._start, self._told = env.environment_steps, 0

    def _on_step(self) -> bool:
        done = self._env.environment_steps - self._start
        if done >= min(self._told + TOLD_EVERY, self._budget):
            self._told = done
            self._progress(done)
            self._progress.policy(done, lambda: self._make(self.model))
        return done < self._budget
