"""How far apart two rewards are, apart from scale and offset; in a canonical form also apart from potential shaping."""

from collections.abc import Mapping
from typing import TypeAlias

import numpy as np

from harness import Float

EPIC, DARD, STARC = FORMS = ("EPIC", "DARD", "STARC")
NOTHING = 1e-9
"""A canonical reward whose spread is a smaller share than this of the largest value paid is constant."""
SHAPING = "one of the two is nothing but an offset and shaping by a potential"


Form: TypeAlias = Float | str | None
"""A reward in one canonical form, over the compared transitions and of length 1; None where it is constant, of STARC
where it is 0; a line where the reward has no such form: why."""
Distance: TypeAlias = float | str
"""How far apart two rewards are in one canonical form, in [0, 1]: 0 the same but for scale, offset and potential
shaping, 0.71 unrelated, 1 opposite; a line where that is not defined: why."""


def compare_forms(
    one: str, of_one: Mapping[str, Form], other: str, of_other: Mapping[str, Form]
) -> dict[str, Distance]:
    """The distances of two rewards by form; their names stand before what is said of them."""
    return {form: _compare(one, of_one[form], other, of_other[form]) for form in of_one}


def _compare(one: str, first: Form, other: str, second: Form) -> Distance:
    if isinstance(first, str):
        return f"{one}: {first}"
    if isinstance(second, str):
        return f"{other}: {second}"
    value = distance_between(first, second)
    return SHAPING if value is None else value


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
