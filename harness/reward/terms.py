"""What a reward returned, as numbers: the pay of steps, and the terms that it is the sum of.

A reward gives its terms as a dict, or as (total, dict). A total, also one under the key ``total``, has to be their sum.
"""

import math
from collections.abc import Mapping
from functools import lru_cache
from types import MappingProxyType
from typing import Any, NamedTuple, cast

import numpy as np

from harness.errors import UsageError
from harness.reward.reward import Array, Carry, Reward
from harness.reward.steps import Steps

TOTAL = "total"
"""The key of a dict of terms under which their sum may stand."""
LONGEST_NAME = 60
"""Characters of the name of a term."""
NO_TERMS: Mapping[str, Array] = MappingProxyType({})


class Paid(NamedTuple):
    """What steps are paid."""

    total: Array
    """What is paid, (num_envs,). Where there are terms it is their sum, in their order."""
    terms: Mapping[str, Array] = NO_TERMS
    """By name, shape (num_envs,) each; none of a reward that returned a plain array."""


def pay(reward: Reward, carry: Carry, steps: Steps) -> tuple[Carry, Paid]:
    """What a reward remembers after steps, and what they are paid.

    Raises:
        UsageError: Its terms are no terms, or their total is not their sum.
    """
    after, returned = reward(carry, steps)
    return after, paid_of(returned)


def paid_of(returned: Any) -> Paid:
    """What a reward returned: an array or a number, a dict of terms, or (total, dict of terms).

    Raises:
        UsageError: The terms are no terms, or the total is not their sum.
    """
    kind = type(returned)  # most steps are paid by an array or a dict: what is quick to see comes first
    if kind is np.ndarray:
        return Paid(returned)
    if kind is dict or isinstance(returned, Mapping):
        return _summed(returned, None)
    if kind is Paid:
        return cast(Paid, returned)
    if isinstance(returned, tuple) and len(returned) == 2 and isinstance(returned[1], Mapping):
        return _summed(returned[1], returned[0])
    return Paid(returned)


def _summed(terms: Mapping[str, Any], total: Any) -> Paid:
    if total is None and TOTAL in terms and len(terms) > 1:
        total, terms = terms[TOTAL], {name: value for name, value in terms.items() if name != TOTAL}
    _require_names(tuple(terms))
    found: Any = sum_of(terms)
    if total is not None and not _is_sum(total, found, terms):
        raise UsageError(
            f"The total {_first(total)} is not the sum of its terms, {_first(found)} "
            f"({', '.join(f'{name} {_first(value)}' for name, value in terms.items())}). Return terms that add up to "
            "it, or the total alone"
        )
    shape = getattr(found, "shape", ())
    for value in terms.values():
        if getattr(value, "shape", ()) != shape:  # a number is that of every env
            return Paid(found, {name: value + 0.0 * found for name, value in terms.items()})
    return Paid(found, terms)


def require_one_each(paid: Paid, count: int) -> None:
    """See that a reward pays one number an arm.

    Args:
        paid: What it pays.
        count: How many arms there are.

    Raises:
        UsageError: It pays something else, such as a number for each joint, or nothing.
    """
    shape = np.shape(paid.total)
    if shape != (count,):
        told = f"values of shape {shape}" if shape else repr(paid.total)
        raise UsageError(f"It returned {told} for {count} arms: {one_each(count)}")


def one_each(count: int) -> str:
    """What a reward is to return for so many arms."""
    return f"return one number an arm, an array of shape ({count},); `.sum(-1)` adds up the joints of each"


def sum_of(terms: Mapping[str, Array]) -> Array:
    """The sum of terms in their order: the same to the last bit wherever it is computed."""
    total: Array = 0.0  # to begin with: two masks are not added as numbers
    for value in terms.values():
        total = total + value
    return total


def require_same(expected: tuple[str, ...], terms: Mapping[str, Array]) -> None:
    """See that a reward pays the terms that it paid before.

    Raises:
        UsageError: It pays others.
    """
    if tuple(terms) != expected and terms.keys() != set(expected):
        raise UsageError(
            f"It paid the terms {', '.join(expected) or 'none'} at first, and now {', '.join(terms) or 'none'}: return "
            "every term in every step, 0 where it pays nothing"
        )


@lru_cache(maxsize=256)  # every step has the same ones
def _require_names(terms: tuple[Any, ...]) -> None:
    if not terms:
        raise UsageError("A dict of terms is empty: return at least one term, {'reach': -step.distance}")
    for name in terms:
        is_name = isinstance(name, str) and 0 < len(name) <= LONGEST_NAME and name.isprintable()
        if not is_name or any(sign in name for sign in "/,:=()") or name.strip() != name:
            raise UsageError(
                f"{name!r} is no name of a term: write letters, digits, '_', '-' or '.', at most {LONGEST_NAME}"
            )


def _is_sum(total: Any, found: Any, terms: Mapping[str, Any]) -> bool:
    """Whether a total is the sum up to what another order of adding, or single precision, may change.

    Terms that cancel out leave an error of their size, which may be large beside their sum. An array of another
    library, as one that JAX compiles with, has no numbers to look at.
    """
    are_floats = isinstance(total, float) and isinstance(found, float)  # else a call of NumPy takes 30 microseconds
    if are_floats and (abs(total - found) <= 1e-6 + 1e-5 * abs(found) or (math.isnan(total) and math.isnan(found))):
        return True
    if any(hasattr(it, "__array_namespace__") and not isinstance(it, np.ndarray | np.generic) for it in (total, found)):
        return True
    told, summed = np.asarray(total, float), np.asarray(found, float)
    rounding = 1e-6 * sum(np.abs(np.asarray(value, float)) for value in terms.values())
    return bool(np.isclose(told, summed, rtol=1e-5, atol=1e-6 + rounding, equal_nan=True).all())


def _first(value: Any) -> str:
    """The first number of a value, for messages."""
    numbers = np.asarray(value, float).ravel()
    return f"{numbers[0]:.6g}" if numbers.size else "nothing"
