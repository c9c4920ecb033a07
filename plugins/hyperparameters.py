"""Hyperparameters that several algorithms have, with what they mean."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field

MOST_ENVS = 10_000
"""The most environments of a training. All are in memory, and no algorithm here learns better from more."""
TOLD_EVERY, SCALARS_EVERY = 100, 1000
"""Environment steps from one report of progress, or of scalars, to the next."""

IN_ENVIRONMENTS: Mapping[str, Any] = MappingProxyType({"gamma": 0.99})
"""Defaults in other people's environments: the discount that the field uses there.

An algorithm's own default was found on the FD100, whose episodes are short. With it, a policy in a longer episode does
not see what its actions lead to.
"""

LearningRate: TypeAlias = Annotated[float, Field(gt=0, description="step size of the optimiser")]
Gamma: TypeAlias = Annotated[float, Field(ge=0, le=1, description="discount factor per decision, 0 to 1, NOTE eq. 12")]
Layers: TypeAlias = Annotated[
    tuple[Annotated[int, Field(gt=0)], ...],
    Field(min_length=1, description="sizes of each network's hidden layers"),
]
BatchSize: TypeAlias = Annotated[int, Field(gt=0, description="transitions per gradient step")]
BufferSize: TypeAlias = Annotated[int, Field(gt=0, description="most transitions that the replay buffer keeps")]
LearningStarts: TypeAlias = Annotated[
    int, Field(ge=0, description="decisions with random actions before the first update")
]
TrainFreq: TypeAlias = Annotated[int, Field(gt=0, description="decisions in each environment between updates")]
GradientSteps: TypeAlias = Annotated[
    int, Field(ge=-1, description="gradient steps per update; -1: as many as new transitions since the last one")
]
Tau: TypeAlias = Annotated[
    float, Field(gt=0, le=1, description="share of the learned weights mixed into the target networks each time")
]
Activation: TypeAlias = Annotated[Literal["relu", "tanh"], Field(description="activation function between the layers")]
NumEnvs: TypeAlias = Annotated[
    int, Field(gt=0, le=MOST_ENVS, description="environments that run side by side in training")
]
