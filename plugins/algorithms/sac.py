"""Soft actor-critic, by stable-baselines3."""

from typing import TYPE_CHECKING

from pydantic.dataclasses import dataclass

from harness.policy import Policy
from harness.progress import Progress
from harness_plugins.soft_actor_critic import SoftActorCritic

if TYPE_CHECKING:
    from harness.env import ReachVectorEnv


@dataclass(frozen=True)
class Sac(SoftActorCritic):
    """stable-baselines3's SAC on the CPU, with settings that learn the FD100 task in 10,000 steps.

    The library's own defaults (learning rate 3e-4, gamma 0.99, 256x256) do not. The entropy coefficient starts at 0.1:
    a step pays some 0.1, and from the library's 1 it takes thousands of steps before the reward outweighs the noise.
    """

    def train(self, env: "ReachVectorEnv", steps: int, seed: int, progress: Progress) -> Policy:
        """See `harness.algorithm.Algorithm`."""
        # Imported here: the settings above are checked before anything runs, and torch takes seconds.
        from stable_baselines3 import SAC

        from harness_plugins.sb3.policies import squashed_gaussian
        from harness_plugins.sb3.training import replay_settings, train

        return train(
            SAC, env, steps, seed, progress,
            lambda model: squashed_gaussian(model, self.activation, "sac"),
            decisions_per_update=self.train_freq * self.num_envs,
            **replay_settings(self, steps),
            ent_coef=self.ent_coef if self.learns_coefficient else self.first_coefficient,
        )  # fmt: skip
