"""Properties of a reward, each tried on numbers: a 'no' is proved by its counter-example, a 'yes' is not proved."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from harness import Float
from harness.files.plain import tells
from harness.payoff.rollout import Rollout, discounted_sum, pay_distances
from harness.reward import Reward
from harness.text import number

from .probe import probe_distances

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


EQUAL = 1e-9
"""Values that differ by no more than this share of the largest are equal."""
GROWN = 1.5
"""A largest value that grows by more than this factor over four decades, or tenfold length, has no bound."""
BOUNDED, SCALE_FREE, POTENTIAL_BASED = "bounded", "scale-free", "potential-based"
SCALES = (0.5, 2.0, 8.0)
"""Powers of two: scaling by them rounds nothing, so that what was equal stays equal."""

FACTOR = 2.0
"""By so much distances are larger in a larger workspace."""


@tells("holds", "evidence", "gamma")
@dataclass(frozen=True)
class Property:
    """One answer.

    Attributes:
        name: What is asked.
        holds: The answer; None where it cannot be asked, and the evidence says why.
        evidence: What it rests on, in words.
        gamma: The discount that it holds for; None where it does not hold, or for any.
    """

    name: str
    holds: bool | None
    evidence: str
    gamma: float | None = None


def properties_of(
    reward: Reward, recorded: Sequence[Float], gamma: float, needed: Sequence[str] = ()
) -> tuple[Property, ...]:
    """Bounded, scale-free, potential-based.

    Args:
        reward: The reward.
        recorded: Distances of recorded rollouts, each (steps + 1, n), [m].
        gamma: The learner's discount per step.
        needed: Fields that it needs beside distances. If there are some, it is not asked.
    """
    if needed:
        why = f"not asked: it reads {', '.join(needed)}, which made-up distances do not have"
        return tuple(Property(name, None, why) for name in (BOUNDED, SCALE_FREE, POTENTIAL_BASED))
    tried = [*recorded, probe_distances(0.05, 1.5)]
    return bounded(reward), scale_free(reward, tried), potential_based(reward, tried, gamma)


def bounded(reward: Reward) -> Property:
    """Whether the shaped reward of a step has a bound, whatever the distances and however long the episode."""
    ways = {
        "distances shrink from 1e-4 to 1e-8 m": (probe_distances(1e-4, 1.0), probe_distances(1e-8, 1.0)),
        "distances grow from 1e3 to 1e7 m": (probe_distances(0.1, 1e3), probe_distances(0.1, 1e7)),
        "an episode grows from 200 to 2,000 steps": (probe_distances(0.05, 1.5, 200), probe_distances(0.05, 1.5, 2000)),
    }
    largest, found = 0.0, []
    for way, (mild, extreme) in ways.items():
        before, after = (_largest(pay_distances(reward, distances)) for distances in (mild, extreme))
        largest = max(largest, after)
        if not (np.isfinite(after) and after <= GROWN * before):
            times = f"{number(after / before)} times" if before > 0.0 and np.isfinite(after) else "beyond every number"
            found.append(f"|r| grows {times} when {way}")
    count = sum(extreme[1:].size for _, extreme in ways.values())
    kept = f"no counter-example in {count:,} samples at 1e-8 to 1e7 m: |r| <= {number(largest)}"
    return Property(BOUNDED, not found, "; ".join(found) or kept)


def scale_free(reward: Reward, tried: Sequence[Float]) -> Property:
    """Whether a step is paid the same when every distance is scaled."""
    ones = [pay_distances(reward, distances) for distances in tried]
    size = max(map(_largest, ones))
    same, in_proportion = 0.0, 0.0
    for scale in SCALES:
        for distances, one in zip(tried, ones, strict=True):
            scaled = pay_distances(reward, scale * distances)
            same = max(same, _largest(scaled - one))
            in_proportion = max(in_proportion, _largest(scaled - scale * one) / scale)
    count = len(SCALES) * sum(one.size for one in ones)
    if same <= EQUAL * size:
        scales = ", ".join(f"{scale:g}" for scale in SCALES)
        return Property(SCALE_FREE, True, f"no counter-example in {count:,} samples scaled by {scales}")
    if in_proportion <= EQUAL * size:
        return Property(SCALE_FREE, False, "in proportion: distances c times as large are paid c times as much")
    return Property(SCALE_FREE, False, f"neither unchanged nor in proportion: it differs by up to {number(same)}")


def potential_based(reward: Reward, tried: Sequence[Float], gamma: float) -> Property:
    """Whether r = gamma phi(s') - phi(s): such a reward does not change which policy is best (Ng et al. 1999).

    The discount may be the learner's, 1, or the one that fits best: a reward has its own.
    """
    first = fit_potential(reward, tried, gamma)
    own = round(first.own_gamma, 3)
    rates = {1.0, own} if 0.0 < own < 1.0 else {1.0}
    fits = [first, *(fit_potential(reward, tried, rate) for rate in sorted(rates - {gamma}))]
    detours = {fit.gamma: worst_detour(reward, tried, fit.gamma) for fit in fits}
    found = [fit for fit in fits if detours[fit.gamma] <= EQUAL]
    count = sum(distances[1:].size for distances in tried)
    if not found:
        best = max(fits, key=lambda fit: fit.explained)
        return Property(
            POTENTIAL_BASED,
            False,
            "with the same first and last state, the way between them changes the sum by up to "
            f"{detours[best.gamma]:.0%} of what is paid; {_explained(best)} (discount {best.gamma:g})",
        )
    rest = waiting_at_target(reward)
    if not abs(rest) <= EQUAL:
        constant = f"except that each step at the target pays {number(rest)}, which matters because episodes end"
        return Property(POTENTIAL_BASED, False, f"{constant} (discount {found[0].gamma:g})")
    text = f"no counter-example in {count:,} samples at a discount of {found[0].gamma:g}: detours pay nothing"
    text += f"; {_explained(found[0])}"
    if found[0].gamma != gamma:
        text += f"; this does not hold for a learner that discounts by {gamma:g}"
    return Property(POTENTIAL_BASED, True, text, found[0].gamma)


def workspace_ratios(reward: Reward, rollouts: Sequence[Rollout]) -> Mapping[str, float | None]:
    """Shaped return of each script with all distances `FACTOR` times as large, over that with them as they are.

    The event terms are the task's and stay: a ratio of 2 halves their weight. None where nothing is paid.
    """
    ratios = dict[str, float | None]()
    for rollout in rollouts:
        usual, larger = (
            float(np.where(rollout.running, pay_distances(reward, factor * rollout.distances), 0.0).sum())
            for factor in (1.0, FACTOR)
        )
        ratios[rollout.script] = larger / usual if usual and np.isfinite(larger / usual) else None
    return ratios


def _explained(fit: PotentialFit) -> str:
    return f"the best phi(d) explains {fit.explained:.1%} of the variance"


def _largest(values: Float) -> float:
    """Largest magnitude; infinite where a value is no number."""
    return float(np.abs(np.nan_to_num(values, nan=np.inf, posinf=np.inf, neginf=-np.inf)).max())
