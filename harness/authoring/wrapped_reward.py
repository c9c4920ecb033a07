"""What rewards that build on another share: the name of the other, and handing its carry through."""

from typing import Annotated, ClassVar, Self

from pydantic import Field, ValidationInfo, model_validator
from pydantic.dataclasses import dataclass

from harness.registry.choice import build_named
from harness.registry.registry import load_registry
from harness.reward import Array, Carry, Reward


@dataclass(frozen=True)
class WrappedReward:
    """A reward made of the one that its parameter `reward` names; a subclass says what becomes of its value.

    A subclass is a frozen dataclass of pydantic too.

    Attributes:
        registered_name: What the subclass is registered as; it cannot stand inside itself.
    """

    registered_name: ClassVar[str]

    reward: Annotated[str, Field(description="the reward inside, name or name:key=value")] = "baseline"

    @model_validator(mode="after")
    def _build_what_is_named(self, info: ValidationInfo) -> Self:
        """By the plugins at hand; who writes ``Scaled("arp")`` in Python has none, and they are loaded for it."""
        registry = (info.context or {}).get("registry") or load_registry()
        label, named = build_named(registry, "rewards", self.reward, within=self.registered_name)
        object.__setattr__(self, "reward", label)  # one text for one reward, however it was typed
        object.__setattr__(self, "_named", named)
        return self

    @property
    def named(self) -> Reward:
        """The reward that `reward` names."""
        named: Reward = vars(self)["_named"]
        return named

    def initial_carry(self, begin_distance: Array) -> Carry:
        """That of the named reward."""
        return self.named.initial_carry(begin_distance)
