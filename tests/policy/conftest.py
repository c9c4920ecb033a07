"""What the tests of several kinds of policy need."""

from collections.abc import Callable

import numpy as np
import pytest


@pytest.fixture(scope="session")
def observations() -> Callable[..., np.ndarray]:
    """Some observations, (count, 5)."""

    def draw(count: int = 4) -> np.ndarray:
        return np.random.default_rng(1).normal(size=(count, 5)).astype(np.float32)

    return draw
