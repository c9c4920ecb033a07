"""How far a ratio can be trusted: bootstrap intervals over seeds."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.index import Index, Ratio, eta_n, eta_p, index_of, mean_curve

Float = NDArray[np.float64]

RESAMPLES = 2_000
CONFIDENCE = 0.95
SEED = 1_05
FEW_SEEDS = 5
_CHUNK = 64


class Comparison(NamedTuple):
    """Two groups of runs compared."""

    baseline: Index
    proposed: Index
    eta_n: Ratio
    eta_p: Ratio


def compare_runs(baseline: Float, proposed: Float) -> Comparison:
    """Indices of both groups and their ratios with intervals.

    Args:
        baseline: Accumulated rewards, (seeds, steps).
        proposed: The same for the proposed reward; row i of both has the same seed. Steps may differ.
    """
    index_b, index_k = index_of(mean_curve(baseline)), index_of(mean_curve(proposed))
    draws = _draw_seeds(len(baseline))
    negative_b, positive_b = _resampled_sums(baseline, draws)
    negative_k, positive_k = _resampled_sums(proposed, draws)
    return Comparison(
        index_b,
        index_k,
        _with_interval(eta_n(index_k, index_b), negative_k, negative_b, "I_N", len(baseline)),
        _with_interval(eta_p(index_k, index_b), positive_k, positive_b, "I_P", len(baseline)),
    )


def _draw_seeds(count: int) -> Float:
    """How often each seed is drawn, as shares, (RESAMPLES, count): both groups take the same draw, seeds are paired."""
    rng = np.random.default_rng(SEED)
    shares: Float = rng.multinomial(count, np.full(count, 1.0 / count), size=RESAMPLES) / count
    return shares


def _resampled_sums(runs: Float, shares: Float) -> tuple[Float, Float]:
    """I_N and I_P, not rounded, of the mean curve of each resample, (RESAMPLES,) both."""
    negative, positive = np.empty(len(shares)), np.empty(len(shares))
    for start in range(0, len(shares), _CHUNK):  # all resampled curves at once would take gigabytes
        part = slice(start, start + _CHUNK)
        curves = shares[part] @ runs
        positive[part] = np.maximum(curves, 0.0).sum(axis=1)
        negative[part] = curves.sum(axis=1) - positive[part]
    return negative, positive


def _with_interval(ratio: Ratio, proposed: Float, baseline: Float, name: str, seeds: int) -> Ratio:
    """The ratio with its percentile interval, or with the reason why there is none."""
    if ratio.value is None:
        return ratio
    if seeds < 2:
        return replace(ratio, note="one seed: no interval")
    undefined = float(np.mean(np.abs(baseline) < 0.05))  # rounds to 0, as the index itself
    if undefined:
        return replace(ratio, note=f"no interval: {name} of the baseline is 0 in {undefined:.0%} of the resamples")
    tail = (1.0 - CONFIDENCE) / 2.0
    low, high = np.quantile(proposed / baseline, [tail, 1.0 - tail])
    note = f"{seeds} seeds: the interval is rough below {FEW_SEEDS}" if seeds < FEW_SEEDS else ""
    return replace(ratio, low=float(low), high=float(high), note=note)
