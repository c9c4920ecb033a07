"""Deep Q-learning, by stable-baselines3."""

from collections.abc import Callable
from typing import Any

from pydantic.dataclasses import dataclass

from harness.algorithm import TrainingEnv
from harness.policy import Policy
from harness.progress import Progress

from ..sb3.q_learning import QLearning


@dataclass(frozen=True)
class Dqn(QLearning):
    """Deep Q-learning (DQ), the NOTE's algorithm for discrete actions, by stable-baselines3.

    Q(s, a) is moved towards r + gamma max_a' Q_target(s', a'), or towards r alone if the episode is terminated.
    """

    def train(self, env: TrainingEnv, steps: int, seed: int, progress: Progress) -> Policy:
        from stable_baselines3 import DQN

        return self.train_with(DQN, "dqn", env, steps, seed, progress)

    def bare_training(self, env: Any, steps: int, seed: int) -> Callable[[], None]:
        """See `harness.algorithm.Algorithm`."""
        from stable_baselines3 import DQN

        from ..sb3.bare import bare_training

        return bare_training(DQN, env, steps, seed, **self.library_settings(steps))
