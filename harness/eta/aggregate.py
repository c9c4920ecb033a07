"""Statistics of a measure over seeds besides its mean, as Agarwal et al. (2021) propose. No single run decides them."""

from collections.abc import Sequence
from typing import Literal

import numpy as np

from harness.arrays import Float


def interquartile_mean(values: Sequence[float]) -> float | None:
    """Mean of the middle half; None for fewer than 4 values, from which no quarter can be left out."""
    count = len(values)
    if count < 4:
        return None
    out = count // 4
    # As scipy.stats.trim_mean, down to the order of the additions; that takes a second to import.
    ordered = np.partition(np.asarray(values, np.float64), (out, count - out - 1))
    return float(np.mean(ordered[out : count - out]))


def probability_of_improvement(
    baseline: Sequence[float], proposed: Sequence[float], better: Literal["higher", "lower"] | str
) -> float | None:
    """Chance that a run of the proposed reward is better than one of the baseline, any against any; ties count half.

    0.5 where neither is better. The Mann-Whitney U over the number of pairs; None without a value on both sides.
    """
    if not len(baseline) or not len(proposed):
        return None
    gains = np.subtract.outer(np.asarray(proposed), np.asarray(baseline))
    share = float(np.mean(gains > 0.0) + 0.5 * np.mean(gains == 0.0))
    return share if better == "higher" else 1.0 - share


def performance_profile(values: Sequence[float], at: Sequence[float] | Float) -> Float:
    """Share of the runs with at least the values `at`, (len(at),). A profile above another one everywhere is better."""
    reached: Float = (np.asarray(values)[None, :] >= np.asarray(at)[:, None]).mean(axis=1)
    return reached
