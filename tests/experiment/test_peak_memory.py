"""The most memory that a process had."""

import sys

import numpy as np
import pytest

from harness.experiment.peak_memory import forget_peak, peak_memory

MIB = 2**20


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="elsewhere a peak cannot be forgotten")
def test_a_peak_is_measured_and_forgotten():
    """What one cell needed is not told of the next one in the same process."""
    forget_peak()
    before = peak_memory()
    many = np.ones(200 * MIB, np.uint8)
    high = peak_memory()
    del many
    forget_peak()
    assert high > before + 190 * MIB
    assert peak_memory() < high - 150 * MIB
