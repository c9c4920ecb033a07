"""Policies: they act with numpy alone, and are saved without pickle."""

from typing import TYPE_CHECKING

from harness.face import face_of

if TYPE_CHECKING:
    from harness.policy.discrete import Categorical as Categorical, Greedy as Greedy, UniformChoice as UniformChoice
    from harness.policy.inverse_kinematics import InverseKinematics as InverseKinematics
    from harness.policy.kinds import every_kind as every_kind, load_policy as load_policy
    from harness.policy.policy import (
        FORMAT as FORMAT,
        Deterministic as Deterministic,
        Gaussian as Gaussian,
        Network as Network,
        Policy as Policy,
        SquashedGaussian as SquashedGaussian,
        Uniform as Uniform,
    )
    from harness.record.folder import CARD as CARD, WEIGHTS as WEIGHTS
else:
    __all__, __getattr__ = face_of(__name__, __file__)
