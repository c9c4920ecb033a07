"""A null control: another reward plus a constant."""

from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.reward import Array, Carry, Pay, Steps, WrappedReward, pay


@dataclass(frozen=True)
class Shifted(WrappedReward):
    """Pays `offset` more than another reward does, at every step.

        r = r_named + offset

    This is a null control of this project: on the same steps the indices change although the robot does nothing better.
    The named reward may have parameters, as in `shifted:reward=arp:k2=2,offset=1`. It may be any registered reward
    except `shifted` itself.

    The value is bounded and scale-free if that of the named reward is. The best policy stays the same only if all
    episodes are equally long. Here reaching the target or touching the ground ends an episode. So an offset above 0
    pays for going on, and one below 0 for ending soon.
    """

    registered_name: ClassVar[str] = "shifted"

    offset: Annotated[Pay, Field(description="constant added to the named reward at every step, in its unit")] = 0.1

    def __call__(self, carry: Carry, steps: Steps) -> tuple[Carry, Array | Mapping[str, Array]]:
        """The named reward's carry, and its value plus `offset`, (num_envs,); beside terms the offset is one more."""
        carry, paid = pay(self.named, carry, steps)
        return carry, {**paid.terms, "offset": self.offset} if paid.terms else paid.total + self.offset
