"""The box of continuous actions, on a card."""

import math
from collections.abc import Mapping
from typing import Any

Ends = tuple[float, ...]


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
    if not all(math.isfinite(a) and math.isfinite(b) and a <= b for a, b in zip(low, high, strict=True)):
        raise ValueError(f"no action lies between {low} and {high}")
    return tuple(low), tuple(high)
