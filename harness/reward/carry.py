"""What a reward remembers inside an episode, and how some episodes of it are taken and put back."""

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Mask

Carry: TypeAlias = Any
"""What a reward remembers inside an episode: an array with a leading num_envs axis, or a tuple of such, or ``()``."""

Selection: TypeAlias = NDArray[np.int64] | Mask
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
