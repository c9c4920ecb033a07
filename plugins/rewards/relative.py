"""The step's gain relative to the distance: NOTE eq. 27-34 and Table III."""

from typing import Annotated, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.reward import Array, Carry, Sample

FLOOR = 1e-6
"""With denominator=current, a smaller distance counts as this one in the denominator, [m]."""


@dataclass(frozen=True)
class Relative:
    """Pays the share of the distance that the step gained or lost.

        denominator=larger:   r = (d(t-1) - d(t)) / max(d(t-1), d(t)), 0 where both are 0
        denominator=current:  r = (d(t-1) - d(t)) / max(d(t), 1e-6 m)

    with the distance d(t) of NOTE eq. 14. Source: NOTE eq. 27-34 and Table III. The value is dimensionless.

    The contradiction: eq. 30 divides by d(t) when coming closer, and eq. 31 says that the result is below 1. But
    (d(t-1) - d(t)) / d(t) is already 1 if a step halves the distance, and has no bound as d(t) goes to 0. Dividing by
    the larger of the two distances keeps what eq. 31, eq. 34 and Table III state: -1 <= r <= 1, with r = 1 for a step
    onto the target. When moving away it equals eq. 33. It is the default, and it is scale-free.

    `current` is eq. 30 and 33 to the letter. It lies between -1 and 0 when moving away, has no upper bound when coming
    closer, and is not defined on the target. To keep it finite there, a distance below one micrometre counts as one
    micrometre in the denominator. So r <= d(t-1) / 1e-6 m, and r = 0 for standing on the target. It is scale-free above
    one micrometre.

    The NOTE has two examples. The first computes |(1,1,2) - (0.5,-1,2)| = sqrt(4.25). The second takes that as d(t),
    with d(t-1) = sqrt(6.25), and gives sqrt(6.25) - sqrt(4.25) = 0.438, which is only the numerator of eq. 30. Divided
    as eq. 30 says, it is 0.213 (`current`). Divided by the larger distance, it is 0.175 (`larger`). The reward that
    pays 0.438 is `baseline-eq21`, or `potential:gamma=1`.
    """

    denominator: Annotated[
        Literal["larger", "current"],
        Field(description="larger: of the two distances, bounded; current: d(t), eq. 30 and 33 to the letter"),
    ] = "larger"

    def initial_carry(self, begin_distance: Array) -> Carry:
        """Remembers nothing."""
        return ()

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        """Shaped reward, (num_envs,), dimensionless."""
        xp = sample.distance.__array_namespace__()
        if self.denominator == "current":
            divisor = xp.where(sample.distance > FLOOR, sample.distance, FLOOR)
        else:
            larger = xp.where(sample.distance > sample.previous_distance, sample.distance, sample.previous_distance)
            divisor = xp.where(larger > 0.0, larger, 1.0)
        return carry, (sample.previous_distance - sample.distance) / divisor
