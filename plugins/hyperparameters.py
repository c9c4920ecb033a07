"""Hyperparameters that several algorithms have, with what they mean."""

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

LearningRate: TypeAlias = Annotated[float, Field(gt=0, description="step size of the optimiser")]
Gamma: TypeAlias = Annotated[float, Field(ge=0, le=1, description="discount, NOTE eq. 12")]
Layers: TypeAlias = Annotated[
    tuple[Annotated[int, Field(gt=0)], ...], Field(min_length=1, description="hidden layers of each network")
]
BatchSize: TypeAlias = Annotated[int, Field(gt=0, description="transitions per update")]
BufferSize: TypeAlias = Annotated[int, Field(gt=0, description="transitions kept for replay")]
LearningStarts: TypeAlias = Annotated[
    int, Field(ge=0, description="decisions with random actions before the first update")
]
TrainFreq: TypeAlias = Annotated[int, Field(gt=0, description="decisions of each env between updates")]
GradientSteps: TypeAlias = Annotated[
    int, Field(ge=-1, description="updates each time; -1: as many as transitions gained")
]
Tau: TypeAlias = Annotated[float, Field(gt=0, le=1, description="share of the new weights in the target networks")]
Activation: TypeAlias = Annotated[Literal["relu", "tanh"], Field(description="between the layers")]
NumEnvs: TypeAlias = Annotated[int, Field(gt=0, description="envs that are trained on at once")]
