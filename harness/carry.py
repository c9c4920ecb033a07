"""What a reward remembers, of several episodes at once: an array with a leading axis, or a tuple of such."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.reward import Carry

Index = NDArray[np.int64] | NDArray[np.bool_]


def replace_where(mask: NDArray[np.bool_], fresh: Carry, kept: Carry) -> Carry:
    """Episodes of `mask`, (n,), from `fresh`, the others from `kept`."""
    if isinstance(fresh, tuple):
        return tuple(replace_where(mask, new, old) for new, old in zip(fresh, kept, strict=True))
    return np.where(mask.reshape(-1, *[1] * (fresh.ndim - 1)), fresh, kept)


def take(carry: Carry, index: Index) -> Carry:
    """Some episodes of a carry, copied."""
    return tuple(take(part, index) for part in carry) if isinstance(carry, tuple) else carry[index]


def put(carry: Carry, index: Index, part: Carry) -> Carry:
    """The carry with some of its episodes replaced by `part`; the carry given stays as it is."""
    if isinstance(carry, tuple):
        return tuple(put(whole, index, piece) for whole, piece in zip(carry, part, strict=True))
    result: Any = np.array(carry, dtype=np.result_type(carry, part))
    result[index] = part
    return result
