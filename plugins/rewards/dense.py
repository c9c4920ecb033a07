"""The negative distance."""

from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.reward import Array, Carry, Sample


@dataclass(frozen=True)
class Dense:
    """Charges the distance to the target at every step.

        r = -scale d(t)

    with d(t) of NOTE eq. 14; the common choice for reaching tasks, in no source of the project. Linear in the distance,
    hence not scale-free; -scale d_max <= r <= 0, d_max the farthest that the arm can be. Not policy-invariant: every
    step costs, so that ending the episode pays, by touching the ground too where that costs less than going on.

    Of the NOTE's example 1, an end effector at (1,1,2) and a target at (0.5,-1,2): r = -sqrt(4.25) = -2.06.
    """

    scale: Annotated[float, Field(gt=0, description="price of a metre per step [1/m]")] = 1.0

    def initial_carry(self, begin_distance: Array) -> Carry:
        """Remembers nothing."""
        return ()

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        """Shaped reward, (num_envs,), <= 0."""
        return carry, -self.scale * sample.distance
