"""The hyperparameters of soft actor-critic, which the algorithms `sac-fast`, `sb3-sac` and `her` share."""

from typing import Annotated, ClassVar

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.algorithm import ActionSpace

from .off_policy import OffPolicy


@dataclass(frozen=True)
class SoftActorCritic(OffPolicy):
    """Settings of soft actor-critic. The defaults learn the FD100 task in 10,000 steps.

    The defaults of stable-baselines3 (learning rate 3e-4, gamma 0.99, two layers of 256) do not. The entropy
    coefficient starts at 0.1, because a step pays about 0.1. If it started at 1, thousands of steps would pass before
    the reward outweighs the entropy.
    """

    ent_coef: Annotated[
        str,
        Field(
            pattern=r"^(auto|auto_(0*[1-9]\d*\.?\d*|\d*\.0*[1-9]\d*)|\d*\.?\d+)$",
            description="entropy coefficient: a fixed number, or auto_X: learned, starting at X (auto: at 1)",
        ),
    ] = "auto_0.1"

    action_spaces: ClassVar[frozenset[ActionSpace]] = frozenset({"continuous"})

    @property
    def learns_coefficient(self) -> bool:
        """Whether the entropy coefficient is learned."""
        return self.ent_coef.startswith("auto")

    @property
    def first_coefficient(self) -> float:
        """The entropy coefficient at the beginning, >= 0."""
        return 1.0 if self.ent_coef == "auto" else float(self.ent_coef.removeprefix("auto_"))
