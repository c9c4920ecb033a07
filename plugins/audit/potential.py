"""Whether a reward is the difference of a potential: r(s, s') = gamma phi(s') - phi(s)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from harness.arrays import Float
from harness.authoring.commands import discounted_sum, pay_distances
from harness.reward import Reward

KNOTS = 32


@dataclass(frozen=True)
class PotentialFit:
    """The best potential of the distance alone.

    Attributes:
        gamma: Discount that the fit was made for.
        explained: Share of the variance of the values that gamma phi(d') - phi(d) and a constant explain.
        own_gamma: The discount that the reward would itself choose: that of r = psi(d') - phi(d), with psi free.
    """

    gamma: float
    explained: float
    own_gamma: float


def fit_potential(reward: Reward, tried: Sequence[Float], gamma: float) -> PotentialFit:
    """Least squares over piecewise linear phi with phi(0) = 0.

    Args:
        reward: The reward.
        tried: Distances of episodes, each (steps + 1, n), [m].
        gamma: Discount per step.
    """
    values = np.concatenate([pay_distances(reward, distances).ravel() for distances in tried])
    before = np.concatenate([distances[:-1].ravel() for distances in tried])
    after = np.concatenate([distances[1:].ravel() for distances in tried])
    finite = np.isfinite(values)
    values, before, after = values[finite], before[finite], after[finite]
    knots = np.linspace(0.0, max(before.max(), after.max()), KNOTS)
    old, new, one = _hats(before, knots), _hats(after, knots), np.ones((len(values), 1))
    phi, psi = np.split(_solve(np.hstack([-old, new, one]), values)[:-1], 2)
    columns = np.hstack([gamma * new - old, one])
    rest = values - columns @ _solve(columns, values)
    spread = np.sum((values - values.mean()) ** 2)
    explained = 1.0 - float(rest @ rest / spread) if spread > 0.0 else 1.0
    return PotentialFit(gamma, explained, float(psi @ phi / (phi @ phi)) if phi.any() else gamma)


def worst_detour(reward: Reward, tried: Sequence[Float], gamma: float) -> float:
    """By how much the way taken changes what an episode pays, as a share of all that it pays.

    Each episode is compared with a detour: same begin, smallest and last distance, same length, anything between.
    Under gamma phi(s') - phi(s) the discounted sum stays the same, whatever phi of (d, smallest so far, begin
    distance) it is. Without discount, and with a `waiting_at_target` of 0, it says that closed loops pay nothing.
    """
    rng = np.random.default_rng(0)
    highest = max(float(distances.max()) for distances in tried)
    worst = 0.0
    for distances in tried:
        ways = [pay_distances(reward, way) for way in (distances, _detour(distances, highest, rng))]
        sums = [discounted_sum(values, gamma) for values in ways]
        gap = np.abs(sums[0] - sums[1]).max()
        size = max(float(discounted_sum(np.abs(values), gamma).max()) for values in ways)
        if not np.isfinite(gap) or not np.isfinite(size):
            return np.inf
        worst = max(worst, float(gap) / size if size > 0.0 else 0.0)
    return worst


def waiting_at_target(reward: Reward) -> float:
    """What a step from the target to the target pays: 0 for a potential that vanishes there."""
    return float(pay_distances(reward, np.array([[0.5], [0.25], [0.0], [0.0]]))[-1, 0])


def _detour(distances: Float, highest: float, rng: np.random.Generator) -> Float:
    """Other distances between the first and the last, up to `highest`; the smallest one stays the smallest."""
    detour, size = distances.copy(), distances[1:-1].shape
    if size[0]:
        lowest = distances[1:-1].min(axis=0)
        detour[1:-1] = lowest + rng.uniform(0.0, 1.0, size) * (highest - lowest)
        detour[rng.integers(1, size[0] + 1, size[1]), np.arange(size[1])] = lowest
    return detour


def _hats(distances: Float, knots: Float) -> Float:
    """Piecewise linear basis, (samples, knots - 1); none for the knot at 0, where a potential is 0."""
    place = distances / knots[1]
    hats: Float = np.maximum(0.0, 1.0 - np.abs(place[:, None] - np.arange(1, len(knots))))
    return hats


def _solve(columns: Float, values: Float) -> Float:
    """Least squares; the shortest solution where there are several."""
    return np.asarray(np.linalg.lstsq(columns, values, rcond=None)[0])
