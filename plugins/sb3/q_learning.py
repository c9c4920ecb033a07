"""What deep Q-learning and double deep Q-learning share: the settings and the training."""

from typing import Annotated, Any, ClassVar

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.algorithm import ActionSpace, Progress, TrainingEnv
from harness.policy import Policy

from ..hyperparameters import BatchSize, Tau
from ..off_policy import OffPolicy
from . import SOURCES

Share = Annotated[float, Field(ge=0, le=1)]


@dataclass(frozen=True)
class QLearning(OffPolicy):
    """Learns what each choice is worth in each state, and mostly takes the best."""

    batch_size: BatchSize = 128
    target_update_interval: Annotated[
        int, Field(gt=0, description="decisions, over all environments, between updates of the target network")
    ] = 1
    tau: Tau = 0.01
    exploration_fraction: Annotated[
        float, Field(gt=0, le=1, description="share of the training over which random choices become rarer")
    ] = 0.3
    exploration_start: Annotated[Share, Field(description="share of random choices at the start of the training")] = 1.0
    exploration_end: Annotated[
        Share, Field(description="share of random choices after that, also in evaluations with deterministic=false")
    ] = 0.05
    max_gradient: Annotated[float, Field(gt=0, description="norm at which gradients are clipped")] = 10.0

    sources: ClassVar[tuple[str, ...]] = SOURCES
    action_spaces: ClassVar[frozenset[ActionSpace]] = frozenset({"discrete"})

    def train_with(
        self, library: Any, name: str, env: TrainingEnv, steps: int, seed: int, progress: Progress
    ) -> Policy:
        """Train the library's class; `name` is the algorithm's name in the policy's card.

        See `harness.algorithm.Algorithm`.
        """
        from .policies import policy_from
        from .training import train

        return train(
            library, env, steps, seed, progress,
            lambda model: policy_from(model, self.activation, name, self.exploration_end),
            decisions_per_update=self.train_freq * self.num_envs,
            **self.library_settings(steps),
        )  # fmt: skip

    def library_settings(self, steps: int) -> dict[str, Any]:
        """The keyword arguments of the library's class, for a training of `steps` environment steps."""
        from .training import replay_settings

        return {
            **replay_settings(self, steps),
            "target_update_interval": max(self.target_update_interval, self.num_envs),  # it cannot be more often
            "exploration_fraction": self.exploration_fraction,
            "exploration_initial_eps": self.exploration_start,
            "exploration_final_eps": self.exploration_end,
            "max_grad_norm": self.max_gradient,
        }
