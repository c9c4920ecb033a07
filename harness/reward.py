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


class Sample(NamedTuple):
    """What the environment tracks at one step, once, for every reward. Arrays of shape (num_envs,)."""

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

    Calling it must not depend on anything but its arguments and its fields, and must not change its arguments: the
    same function pays the learner step by step and scores whole recorded traces afterwards. The events (ground
    contact, target reached, the step's price) belong to the task and are recorded apart.
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
