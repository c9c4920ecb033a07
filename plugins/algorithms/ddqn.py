"""Double deep Q-learning, by stable-baselines3 with another target."""

from typing import TYPE_CHECKING

from pydantic.dataclasses import dataclass

from harness.policy import Policy
from harness.progress import Progress

from ..sb3.q_learning import QLearning

if TYPE_CHECKING:
    from harness.env import ReachVectorEnv


@dataclass(frozen=True)
class Ddqn(QLearning):
    """Double deep Q-learning (DDQ), the NOTE's other algorithm for discrete actions.

    Q(s, a) is moved towards r + gamma Q_target(s', argmax_a' Q(s', a')); r alone where the episode is terminated. All
    else is as in `dqn`.
    """

    def train(self, env: "ReachVectorEnv", steps: int, seed: int, progress: Progress) -> Policy:
        """See `harness.algorithm.Algorithm`."""
        from ..sb3.double import DoubleDQN

        return self.train_with(DoubleDQN, "ddqn", env, steps, seed, progress)
