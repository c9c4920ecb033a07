"""How large or small means can be, also where trainings fail that were not seen."""

import math
from collections.abc import Sequence

import numpy as np

from harness.arrays import Float
from harness.eta.interval import Bounds, Interval, quantile


def difference_bounds(
    baseline: Sequence[Float], proposed: Sequence[Float], ends: Bounds, confidence: float
) -> Interval:
    """Provisional."""
    low = _bound(baseline, proposed, (ends[1], ends[0]), -1.0, confidence)
    return low, _bound(baseline, proposed, ends, 1.0, confidence)


def mean_bounds(values: Sequence[Float], ends: Bounds, confidence: float) -> Interval:
    """Provisional."""
    zero = [np.zeros(2)] * len(values)
    return _bound(zero, values, (math.inf, ends[0]), -1.0, confidence), _bound(
        zero, values, (math.inf, ends[1]), 1.0, confidence
    )


def _bound(one: Sequence[Float], other: Sequence[Float], ends: Bounds, sign: float, confidence: float) -> float:
    total, squares, middle = 0.0, 0.0, 0.0
    for place, sides in enumerate(zip(one, other, strict=True)):
        for values, end, side in zip(sides, ends, (-1.0, 1.0), strict=True):
            there = np.append(values, end) if place == 0 and math.isfinite(end) else values
            part = float(np.var(there, ddof=1)) / len(there) / len(one) ** 2
            middle += side * float(np.mean(there)) / len(one)
            total, squares = total + part, squares + part**2 / (len(there) - 1)
    freedom = total**2 / squares if squares else 1.0
    return middle + sign * quantile(confidence, freedom) * math.sqrt(total)
