"""A null control: another reward plus a constant."""

from typing import Annotated, ClassVar

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.authoring.wrapped_reward import WrappedReward
from harness.reward import Array, Carry, Sample


@dataclass(frozen=True)
class Shifted(WrappedReward):
    """Pays `offset` more than another reward does, at every step.

        r = r_named + offset

    A null control of this project: on the same steps the indices move although nothing was done better. As in
    `shifted:reward=arp:k2=2,offset=1` the named reward may come with parameters; any registered one will do, but not
    `shifted` inside itself.

    Bounded as the named reward is, and scale-free where that is. Which policy is best stays the same only where all
    episodes are equally long. Where reaching the target or touching the ground ends them, as here, an offset above 0
    pays for going on and one below 0 for ending soon.
    """

    registered_name: ClassVar[str] = "shifted"

    offset: Annotated[float, Field(description="what to add at every step, in the unit of the named reward")] = 0.1

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        """The named reward's carry, and its value plus `offset`, (num_envs,)."""
        carry, value = self.named(carry, sample)
        return carry, value + self.offset
