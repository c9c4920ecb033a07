"""The interface that a reward fills: a pure function of steps, R(s, a). And the gate for the numbers of a step.

The gate: what is not finite reaches neither a learner nor a record.
"""

from collections.abc import Mapping
from math import hypot, isfinite, isnan
from typing import Annotated, Any, Protocol, TypeAlias

import numpy as np
from pydantic import Field

from harness.arrays import Ints, Mask
from harness.errors import SimulationDiverged
from harness.reward.steps import Steps

Carry: TypeAlias = Any
"""What a reward remembers inside an episode: an array with a leading num_envs axis, or a tuple of such, or ``()``."""

Selection: TypeAlias = Ints | Mask
"""Some of several episodes: their numbers, or a mask."""


def replace_where(mask: Mask, fresh: Carry, kept: Carry) -> Carry:
    """Episodes of `mask`, (n,), from `fresh`, the others from `kept`."""
    if isinstance(fresh, tuple):
        return tuple(replace_where(mask, new, old) for new, old in zip(fresh, kept, strict=True))
    return np.where(mask.reshape(-1, *[1] * (fresh.ndim - 1)), fresh, kept)


def take(carry: Carry, episodes: Selection) -> Carry:
    """Some episodes of a carry, copied."""
    return tuple(take(part, episodes) for part in carry) if isinstance(carry, tuple) else carry[episodes]


def put(carry: Carry, episodes: Selection, part: Carry) -> Carry:
    """The carry with some of its episodes replaced by `part`; the carry given stays as it is."""
    if isinstance(carry, tuple):
        return tuple(put(whole, episodes, piece) for whole, piece in zip(carry, part, strict=True))
    result: Any = np.array(carry, dtype=np.result_type(carry, part))
    result[episodes] = part
    return result


Array: TypeAlias = Any
"""A numpy array, or another that answers ``__array_namespace__()`` (JAX)."""

LARGEST_FACTOR = 1e18
"""The largest number that a parameter of our rewards and tasks may be: what follows from what they pay stays finite."""
Pay: TypeAlias = Annotated[float, Field(ge=-LARGEST_FACTOR, le=LARGEST_FACTOR, allow_inf_nan=False)]
"""The type of such a parameter, in a dataclass of pydantic's."""


class Reward(Protocol):
    """What pays, whatever a user wrote: `harness.reward.forms` makes one of a plain function.

    A user may write it as a frozen dataclass, whose fields are the reward's parameters. The result must depend only on
    the arguments and the fields, and the call must not change its arguments: the same function pays the learner step by
    step, and later pays whole recorded traces again. What events pay (ground contact, target reached, the price of a
    step) belongs to the task and is recorded separately.

    It may have the attribute ``needs``, a set of names of `harness.reward.steps.ARM`: what it reads. Without it one
    call on made-up steps tells, see `harness.reward.terms.needs_of`.
    """

    def initial_carry(self, begin_distance: Array) -> Carry:
        """What is remembered at the start of an episode, for envs with these begin distances, shape (num_envs,)."""

    def __call__(self, carry: Carry, steps: Steps, /) -> tuple[Carry, Array | Mapping[str, Array]]:
        """The carry after the steps, and what they are paid.

        What they are paid is an array, (num_envs,), or a dict of its terms by name, whose sum is paid.
        """


FEW = 8
"""So many numbers Python looks at sooner than numpy does."""


def is_finite(value: Any) -> bool:
    """Whether each number is: of an array, or of what dicts, tuples and lists hold at any depth. Nothing overflows."""
    if isinstance(value, np.ndarray):
        if value.size <= FEW:
            try:
                if isfinite(hypot(*value.ravel().tolist())):
                    return True
            except (TypeError, OverflowError):  # of what is no number, or none of a machine
                pass
        if value.dtype.kind != "f":
            return value.dtype.kind != "O" or is_finite(value.tolist())
        return 0 not in np.isfinite(value).tobytes()
    if isinstance(value, float):  # mostly; together with the next line it takes twice as long
        return isfinite(value)
    if isinstance(value, np.floating):
        return bool(np.isfinite(value))
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
    raise SimulationDiverged(f"{name}was {'NaN' if isnan(fields) else 'infinite'} at step {step}{where}")


def _inside(value: Any) -> dict[Any, Any]:
    if isinstance(value, dict):
        return value
    value = value.tolist() if isinstance(value, np.ndarray) else value
    return dict(enumerate(value)) if isinstance(value, (tuple, list)) else {}
