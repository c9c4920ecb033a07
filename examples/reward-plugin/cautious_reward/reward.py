"""The reward."""

from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from harness.reward import Array, Carry, Sample


@dataclass(frozen=True)
class Cautious:
    """r = gain (d(t-1) - d(t)): what an episode pays depends on where it ends, not on the way."""

    gain: Annotated[float, Field(gt=0, description="reward per metre")] = 1.0

    def initial_carry(self, begin_distance: Array) -> Carry:
        """Remembers nothing."""
        return ()

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        """Shaped reward, (num_envs,)."""
        return carry, self.gain * (sample.previous_distance - sample.distance)
