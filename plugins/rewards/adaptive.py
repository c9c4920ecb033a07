"""A reward whose gain follows the progress of the episode: this project's definition."""

from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.reward import Array, Carry, Sample

from ..factors import Factor


@dataclass(frozen=True)
class Adaptive:
    """Pays the progress made in the step, times a gain that grows on the way to the target.

        q(t) = Bd / (Bd + d(t))                               progress: 1/2 at the start, 1 on the target, -> 0 far away
        K(t) = k_far + (k_near - k_far) (q(t) + q(t-1)) / 2   gain, between k_far and k_near
        r = K(t) (q(t) - q(t-1))

    with the distance d(t) after step t, and the begin distance Bd = d(0).

    This project's own definition fills a gap: NOTE section XI, "adaptive reward functions", is a heading without text.
    The definition answers section X. That section says that under the baseline a bigger difference brings a bigger
    reward, and calls this "either a bug or less thoughtful design". Here it is the other way round. With
    k_near >= k_far, a step of the same length pays more the nearer to the target it is made, and costs more if it leads
    away.

    The value is dimensionless and scale-free, because distances count relative to the begin distance. It is bounded: r
    is the change of P(q) = k_far q + (k_near - k_far) q^2 / 2, which lies between 0 and (k_far + k_near) / 2. So
    |r| <= (k_far + k_near) / 2, which is 1 with the defaults. For the same reason the rewards of an episode add up to
    P(q(T)) - P(1/2) <= (k_far + 3 k_near) / 8, however long it takes, and moving to and fro pays nothing. The reward
    leaves the best policy unchanged only for a learner that does not discount, see `potential`.
    """

    k_far: Annotated[Factor, Field(description="gain (factor on progress) far away from the target")] = 0.5
    k_near: Annotated[Factor, Field(description="gain (factor on progress) at the target")] = 1.5

    def initial_carry(self, begin_distance: Array) -> Carry:
        """Remembers nothing."""
        return ()

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        """Shaped reward, (num_envs,), dimensionless."""
        before = _progress(sample.begin_distance, sample.previous_distance)
        after = _progress(sample.begin_distance, sample.distance)
        gain = self.k_far + (self.k_near - self.k_far) * (after + before) / 2.0
        return carry, gain * (after - before)


def _progress(begin_distance: Array, distance: Array) -> Array:
    """Bd / (Bd + d), in [0, 1]; 1 on the target, also if the episode began there."""
    xp = distance.__array_namespace__()
    return xp.where(distance > 0.0, begin_distance / xp.where(distance > 0.0, begin_distance + distance, 1.0), 1.0)
