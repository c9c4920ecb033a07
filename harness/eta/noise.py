"""The noise floor: the values that eta takes between two groups of runs that differ only by their seeds."""

import math
from collections.abc import Callable
from statistics import NormalDist

import numpy as np

from harness.arrays import Float
from harness.eta.curve import GroupCurve, mixtures
from harness.eta.index import Ratio
from harness.eta.interval import CONFIDENCE, quantile

SEED = 105
SPLITS = 200
LEAST_RUNS = 4


def noise_floor(baseline: GroupCurve, control: GroupCurve | None, which: int) -> Ratio:
    """The ratio 1, with the range that holds the share `CONFIDENCE` of the etas that seeds alone make.

    With a control, the baseline trained again with as many other seeds, halves of all runs are as large as the groups
    that are compared. Without one, halves of the baseline's runs are smaller than they and differ more: their
    logarithms are scaled by the root of how much smaller. So few runs know their spread only roughly: the range is as
    much wider as Student's interval is than that of the normal distribution.

    Args:
        baseline: Its runs, scored by their own reward.
        control: The baseline trained again with other seeds; None if it was not.
        which: 0 for I_N, 1 for I_P.
    """
    groups = [baseline] if control is None else [baseline, control]
    count = sum(group.count for group in groups)
    told = "" if control is None else "the baseline trained again with other seeds"
    return _range(count, baseline.count, lambda shares: mixtures(groups, shares)[which], "an index of 0", told)


def noise_of_means(values: Float) -> Ratio:
    """The noise floor of a mean over runs of the baseline, such as a mean return.

    Args:
        values: The value of each run, (runs,).
    """
    return _range(len(values), len(values), lambda shares: shares @ values, "a mean that is not above 0", "")


def _range(count: int, compared: int, of: Callable[[Float], Float], undefined: str, told: str) -> Ratio:
    """The range of the ratio of one half's amount to the other half's.

    Args:
        count: How many runs are halved.
        compared: How many runs each group of the real comparison has.
        of: A function from shares of the runs, (splits, count), to the amount, (splits,).
        undefined: What a half has if its amount has no logarithm.
        told: What was halved; empty for the baseline's own runs.
    """
    if count < LEAST_RUNS:
        return Ratio(None, notes=(f"{count} runs of the baseline: halves of them need at least {LEAST_RUNS}",))
    half = count // 2
    first, second = (of(shares) for shares in split_halves(count))
    with np.errstate(all="ignore"):
        logarithms = np.log(first / second) * math.sqrt(half / compared) * _widening(count)
    if not np.isfinite(logarithms).all():
        return Ratio(None, notes=(f"a half of the baseline's runs has {undefined}",))
    tail = (1.0 - CONFIDENCE) / 2.0
    low, high = np.exp(np.quantile(logarithms, [tail, 1.0 - tail]))
    return Ratio(1.0, float(low), float(high), (told or f"halves of {count} runs, scaled to all",))


def _widening(runs: int) -> float:
    return quantile(CONFIDENCE, runs - 1) / NormalDist().inv_cdf(0.5 + CONFIDENCE / 2.0)


def split_halves(count: int, splits: int = SPLITS) -> tuple[Float, Float]:
    """Shares of two disjoint halves of `count` runs, drawn at random, (splits, count) both."""
    rng = np.random.default_rng([SEED, count])
    half = count // 2
    order = rng.permuted(np.tile(np.arange(count), (splits, 1)), axis=1)
    first, second = np.zeros((splits, count)), np.zeros((splits, count))
    np.put_along_axis(first, order[:, :half], 1.0 / half, axis=1)
    np.put_along_axis(second, order[:, half : 2 * half], 1.0 / half, axis=1)
    return first, second
