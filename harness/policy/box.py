"""The box of continuous actions, on a card."""

from collections.abc import Mapping
from typing import Any

Ends = tuple[float, ...]
MOST_ACTIONS = 100
"""At once: an arm has one for each of its joints."""
LARGEST = 1e18
"""The largest size of an end: the difference of both ends is finite in float32."""


def describe_box(low: Ends, high: Ends) -> dict[str, Any]:
    """What a card says of the actions."""
    return {"type": "continuous", "low": list(low), "high": list(high)}


def box_of(card: Mapping[str, Any]) -> tuple[Ends, Ends]:
    """Lower and upper ends of the actions of a card.

    Raises:
        KeyError: The card does not say.
        ValueError: It says what cannot be.
    """
    action = card["action"]
    low, high = ([float(end) for end in action[key]] for key in ("low", "high"))
    if not low or len(low) != len(high):
        raise ValueError(f"the actions have {len(low)} lower and {len(high)} upper ends")
    if len(low) > MOST_ACTIONS:
        raise ValueError(f"there are {len(low):,} actions, {MOST_ACTIONS:,} are allowed")
    if not all(-LARGEST <= a <= b <= LARGEST for a, b in zip(low, high, strict=True)):  # NaN is not either
        raise ValueError(f"no action lies between {low} and {high}")
    return tuple(low), tuple(high)
