"""The choices of discrete actions, on a card."""

from collections.abc import Mapping
from typing import Any


def describe_choices(choices: int) -> dict[str, Any]:
    """What a card says of the actions."""
    return {"type": "discrete", "choices": choices}


def choices_of(card: Mapping[str, Any]) -> int:
    """How many choices the actions of a card are.

    Raises:
        KeyError: The card does not say.
        ValueError: It says what cannot be.
    """
    choices = int(card["action"]["choices"])
    if choices < 1:
        raise ValueError(f"{choices} choices leave none")
    return choices
