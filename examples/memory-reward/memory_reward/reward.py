"""A reward that remembers: it pays progress, and less where the progress is uneven."""

from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from harness.reward import Array, Carry, Sample


@dataclass(frozen=True)
class Steady:
    """r = p - price |p - m|, where p is the gain of the step and m the running mean of the episode's earlier gains.

    m(t) = (1 - share) m(t-1) + share p(t), and m(0) = 0. The reward remembers one number for each env.
    """

    price: Annotated[float, Field(ge=0, description="price of deviating from the usual gain, per metre")] = 0.5
    share: Annotated[float, Field(gt=0, le=1, description="weight of the last step in the running mean, 0 to 1")] = 0.2

    def initial_carry(self, begin_distance: Array) -> Carry:
        """The running mean at the start of an episode, (num_envs,), [m]."""
        xp = begin_distance.__array_namespace__()
        return xp.zeros_like(begin_distance)

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        """The new mean, a new array, and what the step pays; `carry` stays as it is."""
        xp = sample.distance.__array_namespace__()
        gain = sample.previous_distance - sample.distance
        paid = gain - self.price * xp.abs(gain - carry)
        return (1.0 - self.share) * carry + self.share * gain, paid
