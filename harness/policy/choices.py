"""The choices of discrete actions, on a card."""

from collections.abc import Mapping
from typing import Any

MOST_CHOICES = 100_000
"""Three for each of ten joints together are 59,049."""


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
    if choices > MOST_CHOICES:
        raise ValueError(f"there are {choices:,} choices, {MOST_CHOICES:,} are allowed")
    return choices
