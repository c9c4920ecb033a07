"""The negative distance."""

from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.reward import Array, Carry, Sample

from ..factors import Factor


@dataclass(frozen=True)
class Dense:
    """Charges the distance to the target at every step.

        r = -scale d(t)

    with the distance d(t) of NOTE eq. 14. This is the common choice for reaching tasks; no source of the project has
    it. It is linear in the distance, so it is not scale-free; -scale d_max <= r <= 0, where d_max is the farthest that
    the arm can be from the target. It changes which policy is best: every step costs, so ending the episode pays. That
    holds for touching the ground too, if it costs less than going on.

    In the NOTE's example 1 the end effector is at (1,1,2) and the target at (0.5,-1,2): r = -sqrt(4.25) = -2.06.
    """

    scale: Annotated[Factor, Field(description="cost in each step per metre of distance [1/m]")] = 1.0

    def initial_carry(self, begin_distance: Array) -> Carry:
        """Remembers nothing."""
        return ()

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        """Shaped reward, (num_envs,), <= 0."""
        return carry, -self.scale * sample.distance
