"""The gate for numbers: what is not finite reaches neither a learner nor a record."""

import math
from typing import Any

import numpy as np

from harness.errors import SimulationDiverged

FEW = 8
"""So many numbers Python looks at sooner than numpy does."""


def is_finite(value: Any) -> bool:
    """Whether each number is: of an array, or of what dicts, tuples and lists hold at any depth. Nothing overflows."""
    if isinstance(value, np.ndarray):
        if value.dtype.kind != "f":
            return value.dtype.kind != "O" or is_finite(value.tolist())
        if value.ndim == 1 and value.size <= FEW:
            return all(map(math.isfinite, value.tolist()))
        return 0 not in np.isfinite(value).tobytes()
    if isinstance(value, (float, np.floating)):  # a union takes thrice as long
        return math.isfinite(value)
    inside = _inside(value)
    return not inside or all(map(is_finite, inside.values()))


def require_finite(fields: Any, step: int, where: str = "") -> None:
    """Raise SimulationDiverged with the first number that is not: ``observation 1 was NaN at step 150``.

    Args:
        fields: By the names that people know.
        step: That they came with, 0 for the first reset.
        where: Of which env, if there are several.
    """
    if is_finite(fields):
        return
    name = ""
    while inside := _inside(fields):
        key, fields = next((key, it) for key, it in inside.items() if not is_finite(it))
        name += f"{key} "
    raise SimulationDiverged(f"{name}was {'NaN' if math.isnan(fields) else 'infinite'} at step {step}{where}")


def _inside(value: Any) -> dict[Any, Any]:
    if isinstance(value, dict):
        return value
    value = value.tolist() if isinstance(value, np.ndarray) else value
    return dict(enumerate(value)) if isinstance(value, (tuple, list)) else {}
