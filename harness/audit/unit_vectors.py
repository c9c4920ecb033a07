"""How far apart two vectors are, apart from scale, and from offset where it is taken away."""

import numpy as np

from harness.arrays import Float

NOTHING = 1e-9
"""A canonical reward whose spread is a smaller share than this of the largest value paid is constant."""


def distance_between(one: Float | None, other: Float | None) -> float | None:
    """Half the length between two vectors of length 1, in [0, 1]; None stands for a vector of length 0.

    Of two that `centred_unit` made it is sqrt((1 - rho) / 2), with rho their correlation. It is 0 where both are None,
    and None, not defined, where one of them is.
    """
    if one is None and other is None:
        return 0.0
    if one is None or other is None:
        return None
    return min(1.0, float(np.linalg.norm(one - other)) / 2.0)


def centred_unit(values: Float, largest: float) -> Float | None:
    """The values without their mean and of length 1; None where they are constant.

    Args:
        values: Of each transition, (transitions,), at least one.
        largest: The largest that the reward paid; what is small beside it is nothing.
    """
    return unit(values - values.mean(), largest)


def unit(values: Float, largest: float) -> Float | None:
    """The same without taking the mean away; None where they are 0."""
    length = float(np.linalg.norm(values))
    if not length > NOTHING * largest * np.sqrt(len(values)):
        return None
    scaled: Float = values / length
    return scaled
