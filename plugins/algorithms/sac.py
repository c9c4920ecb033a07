"""Soft actor-critic, by stable-baselines3."""

from typing import ClassVar

from pydantic.dataclasses import dataclass

from harness.algorithm import Progress, TrainingEnv
from harness.policy import Policy

from ..sb3 import SOURCES
from ..soft_actor_critic import SoftActorCritic


@dataclass(frozen=True)
class Sac(SoftActorCritic):
    """stable-baselines3's SAC on the CPU, with settings of the harness."""

    sources: ClassVar[tuple[str, ...]] = SOURCES

    def train(self, env: TrainingEnv, steps: int, seed: int, progress: Progress) -> Policy:
        # Imported here: the settings above are checked before anything runs, and torch takes seconds.
        from stable_baselines3 import SAC

        from ..sb3.policies import policy_from
        from ..sb3.training import soft_actor_critic_settings, train

        return train(
            SAC, env, steps, seed, progress,
            lambda model: policy_from(model, self.activation, "sb3-sac"),
            decisions_per_update=self.train_freq * self.num_envs,
            **soft_actor_critic_settings(self, steps),
        )  # fmt: skip
