"""What the tests of several kinds of policy need."""

import numpy as np
import pytest
from numpy.random import default_rng


@pytest.fixture(scope="session")
def observations():
    """Some observations, (count, 5)."""

    def draw(count=4):
        return default_rng(1).normal(size=(count, 5)).astype(np.float32)

    return draw
