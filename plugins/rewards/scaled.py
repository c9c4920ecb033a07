"""A null control: another reward times a constant."""

from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.choice import build_named
from harness.reward import Array, Carry, Reward, Sample


@dataclass(frozen=True)
class Scaled:
    """Pays `factor` times what another reward pays: a change of ruler, and of nothing else.

        r = factor r_named

    A null control of this project: on the same steps every index is multiplied by `factor`, all of it ruler; whoever
    sees better behaviour in it is mistaken. As in `scaled:reward=arp:k2=2,factor=3` the named reward may come with
    parameters; any registered one will do, but not `scaled` inside itself.

    Bounded and scale-free as the named reward is. Which policy is best stays the same as far as the shaped reward goes;
    the task's events are not multiplied with it and weigh less beside it. A learner notices: step sizes and entropy
    bonuses are tuned to the size of a reward.
    """

    reward: Annotated[str, Field(description="the reward to multiply, name or name:key=value")] = "baseline"
    factor: Annotated[float, Field(gt=0, description="what to multiply it by")] = 2.0

    def __post_init__(self) -> None:
        label, named = build_named("rewards", self.reward, within="scaled")
        object.__setattr__(self, "reward", label)  # one text for one reward, however it was typed
        object.__setattr__(self, "_named", named)

    @property
    def named(self) -> Reward:
        """The reward that `reward` names."""
        return self._named

    def initial_carry(self, begin_distance: Array) -> Carry:
        """That of the named reward."""
        return self.named.initial_carry(begin_distance)

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        """The named reward's carry, and its value times `factor`, (num_envs,)."""
        carry, value = self.named(carry, sample)
        return carry, self.factor * value
