"""What rewards that build on another share: the name of the other, and handing its carry through."""

from typing import Annotated, ClassVar

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.registry.choice import build_named
from harness.reward import Array, Carry, Reward


@dataclass(frozen=True)
class WrappedReward:
    """A reward made of the one that its parameter `reward` names; a subclass says what becomes of its value.

    Attributes:
        registered_name: What the subclass is registered as; it cannot stand inside itself.
    """

    registered_name: ClassVar[str]

    reward: Annotated[str, Field(description="the reward inside, name or name:key=value")] = "baseline"

    def __post_init__(self) -> None:
        label, named = build_named("rewards", self.reward, within=self.registered_name)
        object.__setattr__(self, "reward", label)  # one text for one reward, however it was typed
        object.__setattr__(self, "_named", named)

    @property
    def named(self) -> Reward:
        """The reward that `reward` names."""
        named: Reward = vars(self)["_named"]
        return named

    def initial_carry(self, begin_distance: Array) -> Carry:
        """That of the named reward."""
        return self.named.initial_carry(begin_distance)
