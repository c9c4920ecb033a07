"""The rewards."""

from typing import Annotated, ClassVar

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.reward import Array, Carry, Sample
from harness.wrapped_reward import WrappedReward


@dataclass(frozen=True)
class Wary:
    """r = gain (d(t-1) - d(t))."""

    gain: Annotated[float, Field(gt=0, description="reward per metre")] = 1.0

    def initial_carry(self, begin_distance: Array) -> Carry:
        """Remembers nothing."""
        return ()

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        """Shaped reward, (num_envs,)."""
        return carry, self.gain * (sample.previous_distance - sample.distance)


@dataclass(frozen=True)
class Half(WrappedReward):
    """Half of what another reward pays."""

    registered_name: ClassVar[str] = "wary-half"

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        """Half of it, (num_envs,)."""
        carry, value = self.named(carry, sample)
        return carry, 0.5 * value
