"""Potential-based shaping: Ng, Harada and Russell, ICML 1999."""

from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.reward import Array, Carry, Sample


@dataclass(frozen=True)
class Potential:
    """Pays the change of a potential, discounted, so that which policy is best does not change.

        F = gamma phi(t) - phi(t-1) = scale (d(t-1) - gamma d(t)),  phi = -scale d

    Source: Ng, Harada and Russell, "Policy invariance under reward transformations", ICML 1999, theorem 1; d(t) of NOTE
    eq. 14. Over an episode the discounted sum telescopes, whatever happens between its ends:

        sum of gamma^(t-1) F(t) = gamma^T phi(T) - phi(0)

    The best policy is that of the events alone (`sparse`) under two conditions. gamma has to be the learner's discount:
    the default is that of the algorithm `sac` here. And the potential of a state that ends the episode has to be 0: on
    the target it is, but for scale epsilon; on the ground it is not, as a reward knows distances and no events. To hit
    the ground costs gamma scale d more than it should.

    In metres, hence not scale-free; -gamma scale d(t) <= F <= scale d(t-1). With gamma < 1 standing still pays
    scale (1 - gamma) d at every step, the more the farther away: the learner's discount takes it back, an index, which
    sums without a discount, does not. With gamma = 1 and scale = 1 the NOTE's example 2 is paid as it is printed,
    sqrt(6.25) - sqrt(4.25).
    """

    gamma: Annotated[float, Field(gt=0, le=1, description="discount, the same as the learner's")] = 0.95
    scale: Annotated[float, Field(gt=0, description="potential of a metre [1/m]")] = 1.0

    def initial_carry(self, begin_distance: Array) -> Carry:
        """Remembers nothing."""
        return ()

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        """Shaped reward, (num_envs,)."""
        return carry, self.scale * (sample.previous_distance - self.gamma * sample.distance)
