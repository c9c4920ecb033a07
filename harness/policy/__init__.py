"""Policies: they act with numpy alone, and are saved without pickle."""

from harness.policy.categorical import Categorical
from harness.policy.deterministic import Deterministic
from harness.policy.folder import CARD, FORMAT, WEIGHTS
from harness.policy.gaussian import Gaussian
from harness.policy.greedy import Greedy
from harness.policy.inverse_kinematics import InverseKinematics
from harness.policy.kinds import KINDS
from harness.policy.network import Network
from harness.policy.policy import Policy
from harness.policy.squashed_gaussian import SquashedGaussian
from harness.policy.uniform import Uniform
from harness.policy.uniform_choice import UniformChoice

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
]
