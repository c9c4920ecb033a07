"""Soft actor-critic, by stable-baselines3."""

from typing import TYPE_CHECKING, Annotated, ClassVar

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.algorithm import ActionSpace
from harness.policy import Policy
from harness.progress import Progress
from harness_plugins.sb3.settings import (
    Activation,
    BatchSize,
    BufferSize,
    Gamma,
    GradientSteps,
    Layers,
    LearningRate,
    LearningStarts,
    NumEnvs,
    Tau,
    TrainFreq,
)

if TYPE_CHECKING:
    from harness.env import ReachVectorEnv


@dataclass(frozen=True)
class Sac:
    """stable-baselines3's SAC on the CPU, with settings that learn the FD100 task in 10,000 steps.

    The library's own defaults (learning rate 3e-4, gamma 0.99, 256x256) do not. The entropy coefficient starts at 0.1:
    a step pays some 0.1, and from the library's 1 it takes thousands of steps before the reward outweighs the noise.
    """

    learning_rate: LearningRate = 1e-3
    gamma: Gamma = 0.95
    net_arch: Layers = (64, 64)
    batch_size: BatchSize = 256
    buffer_size: BufferSize = 1_000_000
    learning_starts: LearningStarts = 100
    train_freq: TrainFreq = 1
    gradient_steps: GradientSteps = 1
    tau: Tau = 0.005
    ent_coef: Annotated[
        str,
        Field(
            pattern=r"^(auto|auto_0*\.?0*[1-9]\d*\.?\d*|\d*\.?\d+)$",
            description="entropy coefficient: a number, or auto_X to learn it from X on (auto: from 1)",
        ),
    ] = "auto_0.1"
    activation: Activation = "relu"
    num_envs: NumEnvs = 1

    action_spaces: ClassVar[frozenset[ActionSpace]] = frozenset({"continuous"})

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
            ent_coef=self.ent_coef if self.ent_coef.startswith("auto") else float(self.ent_coef),
        )  # fmt: skip
