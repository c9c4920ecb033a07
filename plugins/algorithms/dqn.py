"""Deep Q-learning, by stable-baselines3."""

from pydantic.dataclasses import dataclass

from harness.algorithm import Progress, TrainingEnv
from harness.policy import Policy

from ..sb3.q_learning import QLearning


@dataclass(frozen=True)
class Dqn(QLearning):
    """Deep Q-learning (DQ), the NOTE's algorithm for discrete actions, by stable-baselines3.

    Q(s, a) is moved towards r + gamma max_a' Q_target(s', a'), or towards r alone if the episode is terminated.
    """

    def train(self, env: TrainingEnv, steps: int, seed: int, progress: Progress) -> Policy:
        from stable_baselines3 import DQN

        return self.train_with(DQN, "dqn", env, steps, seed, progress)
