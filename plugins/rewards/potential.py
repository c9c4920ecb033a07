"""Potential-based shaping: Ng, Harada and Russell, ICML 1999."""

from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.reward import Array, Carry, Sample

from ..factors import Factor


@dataclass(frozen=True)
class Potential:
    """Pays the discounted change of a potential, which does not change which policy is best.

        F = gamma phi(t) - phi(t-1) = scale (d(t-1) - gamma d(t)),  phi = -scale d

    with the distance d(t) of NOTE eq. 14. Source: Ng, Harada and Russell, "Policy invariance under reward
    transformations", ICML 1999, theorem 1. The discounted sum over an episode depends only on its first and last state:

        sum of gamma^(t-1) F(t) = gamma^T phi(T) - phi(0)

    The best policy is that of `sparse`, where only the task's events pay, if two conditions hold. First, gamma must be
    the learner's discount. The default is that of the algorithm `sac`. Second, the potential of a state that ends the
    episode must be 0. On the target it is, except for scale epsilon, where epsilon is the task's. On the ground it is
    not, because a reward knows distances and no events. So hitting the ground costs gamma scale d more than it should.

    The value is linear in the distance, so it is not scale-free; -gamma scale d(t) <= F <= scale d(t-1). With gamma < 1
    standing still pays scale (1 - gamma) d at every step, more if the arm is farther away. The learner's discount makes
    up for this. The indices I_N and I_P do not, because they sum without a discount. With gamma = 1 and scale = 1 the
    NOTE's example 2 is paid as printed, sqrt(6.25) - sqrt(4.25).
    """

    gamma: Annotated[float, Field(gt=0, le=1, description="discount factor, which should equal the learner's")] = 0.95
    scale: Annotated[Factor, Field(description="size of the potential per metre of distance [1/m]")] = 1.0

    def initial_carry(self, begin_distance: Array) -> Carry:
        """Remembers nothing."""
        return ()

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        """Shaped reward, (num_envs,)."""
        return carry, self.scale * (sample.previous_distance - self.gamma * sample.distance)
