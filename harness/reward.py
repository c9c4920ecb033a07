"""The interface that a reward fills: a pure function of recorded quantities."""

from typing import Any, NamedTuple, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Mask

Array: TypeAlias = Any
"""A numpy array, or another that answers ``__array_namespace__()`` (JAX)."""

Carry: TypeAlias = Any
"""What a reward remembers inside an episode: an array with a leading num_envs axis, or a tuple of such, or ``()``."""

Selection: TypeAlias = NDArray[np.int64] | Mask
"""Some of several episodes: their numbers, or a mask."""

LARGEST_FACTOR = 1e18
"""The largest number that a parameter of our rewards and tasks may be: what follows from what they pay stays finite."""
LARGEST_PAID = 1e150
"""The largest pay of a step that is counted with: its square is finite."""


class Sample(NamedTuple):
    """What a reward gets to know about one step. Arrays of shape (num_envs,)."""

    begin_distance: Array
    """Bd = d(0), NOTE eq. 22, [m]."""
    previous_best: Array
    """Pb, the smallest distance of the episode before this step; Pb(0) = Bd, NOTE eq. 17, [m]."""
    previous_distance: Array
    """d(t-1), [m]."""
    distance: Array
    """d(t), end effector to target after the step, NOTE eq. 14, [m]."""
    delta_distance: Array
    """d(t) - Pb, NOTE eq. 15, [m]."""
    step: Array
    """t, counted from 1 in each episode."""


class Reward(Protocol):
    """A frozen dataclass whose fields are the reward's parameters.

    The result must depend only on the arguments and the fields, and the call must not change its arguments: the same
    function pays the learner step by step, and later pays whole recorded traces again. What events pay (ground contact,
    target reached, the price of a step) belongs to the task and is recorded separately.
    """

    def initial_carry(self, begin_distance: Array) -> Carry:
        """What is remembered at the start of an episode, for envs with these begin distances, shape (num_envs,)."""

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        """The carry after the step and the shaped reward of the step, shape (num_envs,)."""


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
