"""Double deep Q-learning, by stable-baselines3 with another target."""

from pydantic.dataclasses import dataclass

from harness.algorithm import Progress, TrainingEnv
from harness.policy import Policy

from ..sb3.q_learning import QLearning


@dataclass(frozen=True)
class Ddqn(QLearning):
    """Double deep Q-learning (DDQ), the NOTE's other algorithm for discrete actions.

    Q(s, a) is moved towards r + gamma Q_target(s', argmax_a' Q(s', a')), or towards r alone if the episode is
    terminated. Everything else is as in `dqn`.
    """

    def train(self, env: TrainingEnv, steps: int, seed: int, progress: Progress) -> Policy:
        from ..sb3.double import DoubleDQN

        return self.train_with(DoubleDQN, "ddqn", env, steps, seed, progress)
