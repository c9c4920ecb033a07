"""Whether several rewards come in the same order in several places: Kendall's rank correlation."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from harness.arrays import Float
from harness.eta.interval import why_no_interval

DRAWS = 1_000
"""Of seeds, for the interval."""
REWARDS, PLACES = 3, 2
"""Fewer have no order to compare."""

Runs = Mapping[str, Sequence[float]]
"""The value of each seed, by reward."""


@dataclass(frozen=True)
class Ranking:
    """How alike the orders are.

    Attributes:
        tau: Kendall's tau-b, the mean over all pairs of places: 1 for the same order, -1 for the opposite one, 0 for
            unrelated ones. None where it is not defined.
        low: Lower end of its 95 % interval; None where there is none.
        high: Upper end.
        rewards: How many are ranked.
        places: In how many places.
        note: Why something is missing.
    """

    tau: float | None
    low: float | None = None
    high: float | None = None
    rewards: int = 0
    places: int = 0
    note: str = ""

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {name: getattr(self, name) for name in ("tau", "low", "high", "rewards", "places", "note")}


def rank_agreement(places: Sequence[Runs]) -> Ranking:
    """The agreement of the orders that rewards have by their mean values, over all pairs of places.

    The interval draws the seeds of every training again, with replacement, and takes the middle 95 %: it describes how
    much the number depends on the seeds, not on the choice of places, and with few seeds it is too narrow. Draws blur
    an order, so that a tau near 1 may lie above all of them: the interval always reaches to tau itself.

    Args:
        places: The seeds' values in each; only rewards that all places have are ranked.
    """
    shared = [reward for reward in places[0] if all(place.get(reward) for place in places)] if places else []
    nothing = Ranking(None, rewards=len(shared), places=len(places))
    if len(shared) < REWARDS or len(places) < PLACES:
        note = f"it takes {REWARDS} rewards in {PLACES} places; here are {len(shared)} in {len(places)}"
        return replace(nothing, note=note)
    values = [[np.asarray(place[reward], np.float64) for reward in shared] for place in places]
    values = [[np.asarray(place[reward], np.float64) for reward in shared] for place in places]
    (tau,) = _mean_tau(np.array([[[runs.mean() for runs in place] for place in values]]))
    if np.isnan(tau):
        return replace(nothing, note="in a place all rewards come to the same: they have no order")
    if why_no_interval(min(len(runs) for place in values for runs in place)):
        return replace(nothing, tau=float(tau), note="too few seeds for an interval")
    draws = _mean_tau(_draw(values))
    known = draws[~np.isnan(draws)]
    if len(known) < DRAWS / 2:
        return replace(nothing, tau=float(tau), note="no interval: for most draws of seeds there is no order")
    low, high = np.quantile(known, [0.025, 0.975])
    return replace(nothing, tau=float(tau), low=float(min(low, tau)), high=float(max(high, tau)))


def _draw(values: Sequence[Sequence[Float]]) -> Float:
    """Means of seeds drawn again, (draws, places, rewards)."""
    rng = np.random.default_rng(0)
    drawn = [[rng.choice(runs, (DRAWS, len(runs))).mean(axis=1) for runs in place] for place in values]
    return np.moveaxis(np.array(drawn), -1, 0)


def _mean_tau(means: Float) -> Float:
    """Over all pairs of places, (draws,), for means (draws, places, rewards); NaN where a place has no order.

    A place is the vector of its comparisons, +1, 0 or -1 for each pair of rewards; tau-b of two places is the cosine of
    the angle between theirs, and the mean over all pairs follows from the sum of all unit vectors.
    """
    places, rewards = means.shape[1:]
    first, second = np.triu_indices(rewards, 1)
    signs = np.sign(means[..., first] - means[..., second])
    lengths = np.linalg.norm(signs, axis=-1, keepdims=True)
    units = np.divide(signs, lengths, out=np.full_like(signs, np.nan), where=lengths > 0.0)
    total: Float = (units.sum(axis=1) ** 2).sum(axis=-1)
    mean: Float = np.clip((total - places) / (places * (places - 1)), -1.0, 1.0)  # not 1 and a rounding
    return mean
