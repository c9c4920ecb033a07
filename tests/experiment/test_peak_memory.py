"""The most memory that a process had."""

import mmap
import sys

import pytest

from harness.experiment.run_cell import forget_peak, peak_memory

MIB = 2**20


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="elsewhere a peak cannot be forgotten")
def test_a_peak_is_measured_and_forgotten():
    """What one cell needed is not told of the next one in the same process."""
    forget_peak()
    before = peak_memory()
    # Asked of the system itself: what an array leaves, an allocator may keep.
    with mmap.mmap(-1, 200 * MIB) as many:
        for page in range(0, 200 * MIB, mmap.PAGESIZE):
            many[page] = 1
        high = peak_memory()
    forget_peak()
    assert high > before + 190 * MIB
    assert peak_memory() < high - 150 * MIB
