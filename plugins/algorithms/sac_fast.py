"""Soft actor-critic with numpy alone."""

from typing import ClassVar

from pydantic.dataclasses import dataclass

from harness.algorithm import Progress, TrainingEnv
from harness.policy import SquashedGaussian

from ..soft_actor_critic import SoftActorCritic


@dataclass(frozen=True)
class SacFast(SoftActorCritic):
    """The algorithm of `sb3-sac`, with the same settings. It is about four times as fast with the default networks.

    It uses numpy alone. So it imports no learning library, builds no graph, and allocates nothing large in an update.
    """

    sources: ClassVar[tuple[str, ...]] = ("harness_plugins.fast_sac",)

    def train(self, env: TrainingEnv, steps: int, seed: int, progress: Progress) -> SquashedGaussian:
        from threadpoolctl import threadpool_limits

        from ..fast_sac.training import Training

        # Matrices this small are slower with more threads, and sums come out the same with one.
        with threadpool_limits(1):
            return Training(self, env, steps, seed, progress).run()
