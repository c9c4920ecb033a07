"""The share of one sum in another, with an interval over clusters: a ratio estimator."""

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.eta.interval import CONFIDENCE, LEAST_SEEDS, SHARE, quantile
from harness.eta.seed_mean import SeedMean


def share_of(part: Float, whole: Float, clusters: NDArray[np.int64]) -> SeedMean:
    """How large the sum of `part` is in that of `whole`.

    Args:
        part: By episode, (episodes,), never above `whole`.
        whole: Likewise, never negative.
        clusters: Number of the cluster of each episode, from 0.
    """
    count, total = int(clusters.max(initial=-1)) + 1, float(whole.sum())
    if total <= 0.0:
        return SeedMean(None, None, None, count)
    share = float(part.sum()) / total
    if count < LEAST_SEEDS:
        return SeedMean(share, None, None, count)
    apart = np.bincount(clusters, part - share * whole, count) / total
    reach = quantile(CONFIDENCE, count - 1) * float(np.sqrt(apart @ apart * count / (count - 1)))
    return SeedMean(share, max(SHARE[0], share - reach), min(SHARE[1], share + reach), count)
