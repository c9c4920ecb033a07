"""Names of the array types; shape, unit and frame stand beside each use."""

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

__all__ = ["Float", "Float32", "Ints", "Mask"]

Float: TypeAlias = NDArray[np.float64]
"""Numbers of 64 bits."""
Float32: TypeAlias = NDArray[np.float32]
"""Numbers of 32 bits."""
Ints: TypeAlias = NDArray[np.int64]
"""Whole numbers."""
Mask: TypeAlias = NDArray[np.bool_]
"""What holds, and what does not."""


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """A view of an array that cannot be written into; it shows what its owner writes."""
    view = array.view()
    view.setflags(write=False)
    return view
