"""The hyperparameters of soft actor-critic, whoever does it."""

from typing import Annotated, ClassVar

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.algorithm import ActionSpace
from harness_plugins.hyperparameters import (
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


@dataclass(frozen=True)
class SoftActorCritic:
    """Settings that learn the FD100 task in 10,000 steps; stable-baselines3's own (3e-4, 0.99, 256x256) do not.

    The entropy coefficient starts at 0.1: a step pays some 0.1, and from 1 it takes thousands of steps before the
    reward outweighs the noise.
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
            pattern=r"^(auto|auto_(0*[1-9]\d*\.?\d*|\d*\.0*[1-9]\d*)|\d*\.?\d+)$",
            description="entropy coefficient: a number, or auto_X to learn it from X on (auto: from 1)",
        ),
    ] = "auto_0.1"
    activation: Activation = "relu"
    num_envs: NumEnvs = 1

    action_spaces: ClassVar[frozenset[ActionSpace]] = frozenset({"continuous"})

    @property
    def learns_coefficient(self) -> bool:
        """Whether the entropy coefficient is learned."""
        return self.ent_coef.startswith("auto")

    @property
    def first_coefficient(self) -> float:
        """The entropy coefficient in the beginning."""
        return 1.0 if self.ent_coef == "auto" else float(self.ent_coef.removeprefix("auto_"))
