"""The hyperparameters of algorithms that learn from a replay buffer."""

from collections.abc import Mapping
from typing import Any, ClassVar

from pydantic.dataclasses import dataclass

from .hyperparameters import (
    IN_ENVIRONMENTS,
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
class OffPolicy:
    """The hyperparameters that all off-policy algorithms share. The defaults are those for continuous actions."""

    learning_rate: LearningRate = 1e-3
    gamma: Gamma = 0.95
    net_arch: Layers = (64, 64)
    batch_size: BatchSize = 256
    buffer_size: BufferSize = 1_000_000
    learning_starts: LearningStarts = 100
    train_freq: TrainFreq = 1
    gradient_steps: GradientSteps = 1
    tau: Tau = 0.005
    activation: Activation = "relu"
    num_envs: NumEnvs = 1

    in_environments: ClassVar[Mapping[str, Any]] = IN_ENVIRONMENTS
