"""The hyperparameters of soft actor-critic, whoever does it."""

from typing import Annotated, ClassVar

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.algorithm import ActionSpace

from .off_policy import OffPolicy


@dataclass(frozen=True)
class SoftActorCritic(OffPolicy):
    """Settings that learn the FD100 task in 10,000 steps; stable-baselines3's own (3e-4, 0.99, 256x256) do not.

    The entropy coefficient starts at 0.1: a step pays some 0.1, and from 1 it takes thousands of steps before the
    reward outweighs the noise.
    """

    ent_coef: Annotated[
        str,
        Field(
            pattern=r"^(auto|auto_(0*[1-9]\d*\.?\d*|\d*\.0*[1-9]\d*)|\d*\.?\d+)$",
            description="entropy coefficient: a number, or auto_X to learn it from X on (auto: from 1)",
        ),
    ] = "auto_0.1"

    action_spaces: ClassVar[frozenset[ActionSpace]] = frozenset({"continuous"})

    @property
    def learns_coefficient(self) -> bool:
        """Whether the entropy coefficient is learned."""
        return self.ent_coef.startswith("auto")

    @property
    def first_coefficient(self) -> float:
        """The entropy coefficient in the beginning."""
        return 1.0 if self.ent_coef == "auto" else float(self.ent_coef.removeprefix("auto_"))
