"""Policies: they act with numpy alone, and are saved without pickle."""

from typing import TYPE_CHECKING

from harness.face import face_of

if TYPE_CHECKING:
    from harness.authoring.layers import layer_weights as layer_weights
    from harness.policy.discrete import Categorical as Categorical, Greedy as Greedy, UniformChoice as UniformChoice
    from harness.policy.kinds import load_policy as load_policy
    from harness.policy.policy import (
        Deterministic as Deterministic,
        Gaussian as Gaussian,
        Policy as Policy,
        SquashedGaussian as SquashedGaussian,
        Uniform as Uniform,
    )
else:
    __all__, __getattr__ = face_of(__name__)
