"""Policies: they act with numpy alone, and are saved without pickle."""

from harness.policy.continuous import Deterministic, Gaussian, Network, SquashedGaussian, Uniform
from harness.policy.discrete import Categorical, Greedy, UniformChoice
from harness.policy.inverse_kinematics import InverseKinematics
from harness.policy.kinds import KINDS, load_policy
from harness.policy.policy import FORMAT, Policy
from harness.record.folder import CARD, WEIGHTS

__all__ = [
    "CARD",
    "FORMAT",
    "KINDS",
    "WEIGHTS",
    "Categorical",
    "Deterministic",
    "Gaussian",
    "Greedy",
    "InverseKinematics",
    "Network",
    "Policy",
    "SquashedGaussian",
    "Uniform",
    "UniformChoice",
    "load_policy",
]
