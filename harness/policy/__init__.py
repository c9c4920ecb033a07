"""Policies: they act with numpy alone, and are saved without pickle."""

from harness.policy.categorical import Categorical
from harness.policy.deterministic import Deterministic
from harness.policy.folder import FORMAT
from harness.policy.gaussian import Gaussian
from harness.policy.greedy import Greedy
from harness.policy.inverse_kinematics import InverseKinematics
from harness.policy.kinds import KINDS, load_policy
from harness.policy.network import Network
from harness.policy.policy import Policy
from harness.policy.squashed_gaussian import SquashedGaussian
from harness.policy.uniform import Uniform
from harness.policy.uniform_choice import UniformChoice
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
