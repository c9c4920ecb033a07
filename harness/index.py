"""The note's indices of a group of runs, I_N and I_P, and their ratios, eta_N and eta_P.

As they were computed for the published table (NOTE eq. 38-44 with r_1 the accumulated reward).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]

DECIMALS = 1
"""I_N and I_P are rounded to 0.1, as published."""


@dataclass(frozen=True)
class Index:
    """What the mean curve of a group says.

    Attributes:
        first_negative: First step at which the curve is negative, counted from 0; None if it never is.
        crossover: First step after it at which the curve is not negative; None if there is none.
        steps: Length of the curve.
        I_N: Sum of the curve's negative values, <= 0, rounded to 0.1.
        I_P: Sum of its positive values, >= 0, rounded to 0.1.
    """

    first_negative: int | None
    crossover: int | None
    steps: int
    I_N: float
    I_P: float


@dataclass(frozen=True)
class Ratio:
    """A ratio with its interval, or the reason why there is none.

    Attributes:
        value: None where the ratio is not defined.
        low: Lower end of the 95 % interval; None where there is none.
        high: Upper end.
        note: Why something is None, or what to keep in mind; may be empty.
    """

    value: float | None
    low: float | None = None
    high: float | None = None
    note: str = ""


def accumulated_reward(reward: Float) -> Float:
    """Running sum of a run's reward column over the whole run, episode-start rows included, (steps,)."""
    return np.cumsum(reward, dtype=np.float64)


def stack_runs(rewards: Sequence[Float]) -> Float:
    """Accumulated rewards of a group's runs, each cut to the shortest run, (runs, steps)."""
    steps = min(len(reward) for reward in rewards)
    return np.stack([accumulated_reward(reward[:steps]) for reward in rewards])


def mean_curve(runs: Float) -> Float:
    """The group's curve: the mean over its runs at each step, (runs, steps) -> (steps,)."""
    curve: Float = runs.mean(axis=0)
    return curve


def index_of(curve: Float) -> Index:
    """The index of a mean curve, (steps,)."""
    negative = curve < 0.0
    first = int(np.argmax(negative)) if negative.any() else None
    crossover = None
    if first is not None and not negative[first:].all():
        crossover = first + int(np.argmin(negative[first:]))
    return Index(first, crossover, len(curve), _sum(curve[negative]), _sum(curve[curve > 0.0]))


def eta_n(proposed: Index, baseline: Index) -> Ratio:
    """I_N of the proposed reward over I_N of the baseline, NOTE eq. 43; below 1 is better."""
    return _ratio(proposed.I_N, baseline.I_N, "I_N of the baseline is 0: its mean accumulated reward is never negative")


def eta_p(proposed: Index, baseline: Index) -> Ratio:
    """I_P of the proposed reward over I_P of the baseline, NOTE eq. 44; above 1 is better."""
    return _ratio(proposed.I_P, baseline.I_P, "I_P of the baseline is 0: its mean accumulated reward is never positive")


def _ratio(numerator: float, denominator: float, reason: str) -> Ratio:
    return Ratio(numerator / denominator + 0.0) if denominator else Ratio(None, note=reason)


def _sum(values: Float) -> float:
    """Rounded as published; + 0.0 turns -0.0, which no reader expects, into 0.0."""
    return round(float(values.sum()), DECIMALS) + 0.0
