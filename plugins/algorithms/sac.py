"""Soft actor-critic, by stable-baselines3."""

from typing import TYPE_CHECKING, ClassVar

from pydantic.dataclasses import dataclass

from harness.policy import Policy
from harness.progress import Progress

from ..sb3 import SOURCES
from ..soft_actor_critic import SoftActorCritic

if TYPE_CHECKING:
    from harness.env import ReachVectorEnv


@dataclass(frozen=True)
class Sac(SoftActorCritic):
    """stable-baselines3's SAC on the CPU, with settings of the harness."""

    sources: ClassVar[tuple[str, ...]] = SOURCES

    def train(self, env: "ReachVectorEnv", steps: int, seed: int, progress: Progress) -> Policy:
        """See `harness.algorithm.Algorithm`."""
        # Imported here: the settings above are checked before anything runs, and torch takes seconds.
        from stable_baselines3 import SAC

        from ..sb3.policies import squashed_gaussian
        from ..sb3.training import replay_settings, train

        return train(
            SAC, env, steps, seed, progress,
            lambda model: squashed_gaussian(model, self.activation, "sac"),
            decisions_per_update=self.train_freq * self.num_envs,
            **replay_settings(self, steps),
            ent_coef=self.ent_coef if self.learns_coefficient else self.first_coefficient,
        )  # fmt: skip
