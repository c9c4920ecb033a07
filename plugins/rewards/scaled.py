"""A null control: another reward times a constant."""

from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.reward import Array, Carry, Steps, WrappedReward, pay

from ..factors import Factor


@dataclass(frozen=True)
class Scaled(WrappedReward):
    """Pays `factor` times what another reward pays. Nothing but the ruler changes.

        r = factor r_named

    This is a null control of this project. On the same steps every index is multiplied by `factor`. All of that is
    ruler, the part of an eta that comes from counting differently; none of it is better behaviour. The named reward may
    have parameters, as in `scaled:reward=arp:k2=2,factor=3`. It may be any registered reward except `scaled` itself.

    The value is bounded and scale-free if that of the named reward is. The shaped reward alone leaves the best policy
    unchanged. But the task's events are not multiplied, so with a factor above 1 they weigh less. A learner may behave
    differently, because step sizes and entropy bonuses are tuned to the size of a reward.
    """

    registered_name: ClassVar[str] = "scaled"

    factor: Annotated[Factor, Field(description="factor on the named reward")] = 2.0

    def __call__(self, carry: Carry, steps: Steps) -> tuple[Carry, Array | Mapping[str, Array]]:
        """The named reward's carry, and its value, or each of its terms, times `factor`, (num_envs,)."""
        carry, paid = pay(self.named, carry, steps)
        return carry, {name: self.factor * term for name, term in paid.terms.items()} or self.factor * paid.total
