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
    """By hand: means and standard deviations of equally many."""
    steps, numbers = episodes_of(count)
    blocks = Blocks.of(["effort"], steps, numbers)
    size = next(2**k for k in range(20) if count <= 2**k * 64)
    assert len(blocks.listed) == math.ceil(count / size)
    for index, block in enumerate(blocks.listed):
        part = slice(index * size, (index + 1) * size)
        pay = numbers[part, 0].tolist()
        assert (block.episodes, block.steps) == (len(pay), steps[part][-1])
        assert block.pay == pytest.approx(statistics.fmean(pay))
        spread = statistics.stdev(pay) if len(pay) > 1 else math.nan
        assert block.pay_spread == pytest.approx(spread, nan_ok=True)
        assert block.behaviour == pytest.approx(numbers[part, 1].mean())


def test_behaviour_that_nobody_measures_is_nan():
    """And the pay is known all the same."""
    blocks = Blocks.of((), np.array([10, 20]), np.array([[1.0, math.nan], [3.0, math.nan]]))
    assert blocks.listed[0].pay == 1.0
    assert math.isnan(blocks.listed[1].behaviour)
