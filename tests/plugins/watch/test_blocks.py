import math
import statistics

import numpy as np
import pytest

from harness_plugins.watch.blocks import Blocks

RNG = np.random.default_rng(7)


def episodes_of(count):
    """Steps and numbers of some episodes: pay, success, one term."""
    return np.arange(1, count + 1) * 50, RNG.normal(1e3, 3.0, (count, 3))


@pytest.mark.parametrize("count", [1, 63, 64, 65, 129, 1_000])
def test_blocks_are_the_episodes_one_after_the_other(count):
    """By hand: means of equally many."""
    steps, numbers = episodes_of(count)
    blocks = Blocks.of(["effort"], steps, numbers)
    size = next(2**k for k in range(20) if count <= 2**k * 64)
    assert len(blocks) == math.ceil(count / size)
    for index, means in enumerate(blocks.means):
        part = slice(index * size, (index + 1) * size)
        assert (blocks.episodes[index], blocks.steps[index]) == (len(numbers[part]), steps[part][-1])
        assert means.tolist() == pytest.approx([statistics.fmean(it) for it in numbers[part].T])


def test_behaviour_that_nobody_measures_is_nan():
    """And the pay is known all the same."""
    blocks = Blocks.of((), np.array([10, 20]), np.array([[1.0, math.nan], [3.0, math.nan]]))
    assert blocks.means[0, 0] == 1.0
    assert math.isnan(blocks.means[1, 1])
