"""Every kind of policy that a card may name."""

from harness.policy.categorical import Categorical
from harness.policy.deterministic import Deterministic
from harness.policy.gaussian import Gaussian
from harness.policy.greedy import Greedy
from harness.policy.inverse_kinematics import InverseKinematics
from harness.policy.policy import Policy
from harness.policy.squashed_gaussian import SquashedGaussian
from harness.policy.uniform import Uniform
from harness.policy.uniform_choice import UniformChoice

KINDS: tuple[type[Policy], ...] = (
    SquashedGaussian,
    Gaussian,
    Deterministic,
    Greedy,
    Categorical,
    Uniform,
    UniformChoice,
    InverseKinematics,
)
"""A new kind is one line here."""


def kind_named(name: str) -> type[Policy]:
    """The kind of that name.

    Raises:
        ValueError: There is none; names those that there are.
    """
    for kind in KINDS:
        if kind.kind == name:
            return kind
    raise ValueError(f"no kind {name!r}; there is: {', '.join(kind.kind for kind in KINDS)}")
