"""The base class of rewards that build on another reward. It holds that reward and passes its carry on."""

from typing import Annotated, ClassVar, Self

from pydantic import Field, ValidationInfo, model_validator
from pydantic.dataclasses import dataclass

from harness.registry.choice import build_named
from harness.registry.registry import load_registry
from harness.reward import Array, Carry, Reward


@dataclass(frozen=True)
class WrappedReward:
    """A reward that changes the value of another reward, which its parameter `reward` names.

    A subclass is a frozen dataclass of pydantic too. Its ``__call__`` computes the new value.

    Attributes:
        registered_name: The name under which the subclass is registered. It must not stand inside itself, so `reward`
            cannot have this name.
    """

    registered_name: ClassVar[str]

    reward: Annotated[str, Field(description="the reward inside, name or name:key=value")] = "baseline"

    @model_validator(mode="after")
    def _build_what_is_named(self, info: ValidationInfo) -> Self:
        """Build the named reward from the plugins in the validation context.

        Python code such as ``Scaled("arp")`` has no such context, so all plugins are loaded for it.
        """
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
        """The initial carry of the named reward."""
        return self.named.initial_carry(begin_distance)
