"""A null control: another reward times a constant."""

from typing import Annotated, ClassVar

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.authoring.wrapped_reward import WrappedReward
from harness.reward import Array, Carry, Sample


@dataclass(frozen=True)
class Scaled(WrappedReward):
    """Pays `factor` times what another reward pays: a change of ruler, and of nothing else.

        r = factor r_named

    A null control of this project: on the same steps every index is multiplied by `factor`, all of it ruler; whoever
    sees better behaviour in it is mistaken. As in `scaled:reward=arp:k2=2,factor=3` the named reward may come with
    parameters; any registered one will do, but not `scaled` inside itself.

    Bounded and scale-free as the named reward is. Which policy is best stays the same as far as the shaped reward goes;
    the task's events are not multiplied with it and weigh less beside it. A learner notices: step sizes and entropy
    bonuses are tuned to the size of a reward.
    """

    registered_name: ClassVar[str] = "scaled"

    factor: Annotated[float, Field(gt=0, description="what to multiply it by")] = 2.0

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        """The named reward's carry, and its value times `factor`, (num_envs,)."""
        carry, value = self.named(carry, sample)
        return carry, self.factor * value
