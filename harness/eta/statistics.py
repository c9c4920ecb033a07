"""How far a difference can be trusted: bootstrap over seeds, noise floor, correction for many comparisons."""

import math
from collections.abc import Sequence

import numpy as np

from harness.arrays import Float

RESAMPLES = 2_000
CONFIDENCE = 0.95
SEED = 105
FEW_SEEDS = 5
MANY_SEEDS = 1_000


def draw_shares(count: int, stream: int = 0) -> Float:
    """How often each of `count` seeds is drawn with replacement, as shares, (RESAMPLES, count).

    Args:
        count: How many seeds there are.
        stream: The same number gives the same draws: groups whose seeds are paired take the same.
    """
    rng = np.random.default_rng([SEED, stream])
    shares: Float = rng.multinomial(count, np.full(count, 1.0 / count), size=RESAMPLES) / count
    return shares


def percentile_interval(values: Float) -> tuple[float, float]:
    """The middle CONFIDENCE of resampled values. Of ratios it is that of their logarithms: percentiles keep order."""
    tail = (1.0 - CONFIDENCE) / 2.0
    low, high = np.quantile(values, [tail, 1.0 - tail])
    return float(low), float(high)


def interval_notes(seeds: int) -> tuple[str, ...]:
    """What to keep in mind of an interval over so many seeds, at least 1; nothing from FEW_SEEDS on."""
    if seeds == 1:
        return ("one seed: no interval",)
    return (f"{seeds} seeds: the interval is rough below {FEW_SEEDS}",) if seeds < FEW_SEEDS else ()


def p_value(values: Float, null: float) -> float:
    """Two-sided bootstrap p-value of `null`, in (0, 1]: twice the share of resamples on its far side."""
    smaller = min(int((values <= null).sum()), int((values >= null).sum()))
    return min(1.0, 2.0 * (smaller + 1) / (len(values) + 1))


def holm(p_values: Sequence[float]) -> list[float]:
    """Holm's correction: p-values that hold for all of several comparisons together."""
    order = sorted(range(len(p_values)), key=lambda i: p_values[i])
    corrected, largest = [0.0] * len(p_values), 0.0
    for rank, i in enumerate(order):
        largest = max(largest, min(1.0, p_values[i] * (len(p_values) - rank)))
        corrected[i] = largest
    return corrected


def seeds_to_decide(values: Float, ratio: float, seeds: int) -> int | None:
    """How many seeds would show that a ratio is not 1, if it stays as it is and its spread falls as 1 / sqrt(seeds).

    Args:
        values: The resampled ratios, (draws,).
        ratio: The ratio itself.
        seeds: How many seeds they rest on.

    Returns:
        At least `seeds`; None where more than MANY_SEEDS would be needed, or no number can be told.
    """
    if ratio <= 0.0 or not (values > 0.0).all() or math.log(ratio) == 0.0:
        return None
    spread = float(np.std(np.log(values)))
    needed = math.ceil(seeds * (1.96 * spread / abs(math.log(ratio))) ** 2)
    return max(seeds, needed) if needed <= MANY_SEEDS else None


def split_halves(count: int, splits: int = 200) -> tuple[Float, Float]:
    """Shares of two disjoint halves of `count` seeds, drawn at random, (splits, count) both; A/A comparisons."""
    rng = np.random.default_rng([SEED, count])
    half = count // 2
    order = rng.permuted(np.tile(np.arange(count), (splits, 1)), axis=1)
    first, second = np.zeros((splits, count)), np.zeros((splits, count))
    np.put_along_axis(first, order[:, :half], 1.0 / half, axis=1)
    np.put_along_axis(second, order[:, half : 2 * half], 1.0 / half, axis=1)
    return first, second
