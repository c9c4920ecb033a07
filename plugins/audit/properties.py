"""Properties of a reward, each tried on numbers: a 'no' is proved by its counter-example, a 'yes' is not proved."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from harness.arrays import Float
from harness.authoring.commands import Rollout, pay_distances
from harness.reward import Reward
from harness.text import number

from .potential import PotentialFit, fit_potential, waiting_at_target, worst_detour
from .probe import probe_distances, why_not_asked

EQUAL = 1e-9
"""Values that differ by no more than this share of the largest are equal."""
GROWN = 1.5
"""A largest value that grows by more than this factor over four decades, or tenfold length, has no bound."""
BOUNDED, SCALE_FREE, POTENTIAL_BASED = "bounded", "scale-free", "potential-based"
SCALES = (0.5, 2.0, 8.0)
"""Powers of two: scaling by them rounds nothing, so that what was equal stays equal."""

FACTOR = 2.0
"""By so much distances are larger in a larger workspace."""


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
        return tuple(Property(name, None, why_not_asked(needed)) for name in (BOUNDED, SCALE_FREE, POTENTIAL_BASED))
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
            found.append(f"|r| grows {_growth(before, after)} when {way}")
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
        return Property(SCALE_FREE, True, f"no counter-example in {count:,} samples scaled by {_scales()}")
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
        return Property(POTENTIAL_BASED, False, _why_not(max(fits, key=lambda fit: fit.explained), detours))
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
    return {rollout.script: _ratio(reward, rollout) for rollout in rollouts}


def _ratio(reward: Reward, rollout: Rollout) -> float | None:
    usual, larger = (
        float(np.where(rollout.running, pay_distances(reward, factor * rollout.distances), 0.0).sum())
        for factor in (1.0, FACTOR)
    )
    return larger / usual if usual and np.isfinite(larger / usual) else None


def _why_not(fit: PotentialFit, detours: dict[float, float]) -> str:
    return (
        "with the same first and last state, the way between them changes the sum by up to "
        f"{detours[fit.gamma]:.0%} of what is paid; {_explained(fit)} (discount {fit.gamma:g})"
    )


def _explained(fit: PotentialFit) -> str:
    return f"the best phi(d) explains {fit.explained:.1%} of the variance"


def _largest(values: Float) -> float:
    """Largest magnitude; infinite where a value is no number."""
    return float(np.abs(np.nan_to_num(values, nan=np.inf, posinf=np.inf, neginf=-np.inf)).max())


def _growth(before: float, after: float) -> str:
    return f"{number(after / before)} times" if before > 0.0 and np.isfinite(after) else "beyond every number"


def _scales() -> str:
    return ", ".join(f"{scale:g}" for scale in SCALES)
