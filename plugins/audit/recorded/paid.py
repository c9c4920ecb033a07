"""What several rewards paid for the same steps or episodes, and how far apart two of them are in that."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from harness.arrays import Float
from harness.log import REWARD, Log

from ..distance import centred_unit, distance_between

NOT_KNOWN = "not a number in some rows"


@dataclass(frozen=True, eq=False)
class Paid:
    """What rewards paid for one set of recorded steps.

    Attributes:
        steps: By reward, what it pays for each step, (steps,), finite; only rewards that are known in every step.
        returns: By reward, its sum over each finished episode, (episodes,).
        unknown: By reward that is not known in every step: why.
    """

    steps: Mapping[str, Float]
    returns: Mapping[str, Float]
    unknown: Mapping[str, str]


def paid_in(log: Log) -> Paid:
    """What the rewards of a log paid, in its steps and in its finished episodes; of a log of episodes, in these alone.

    Args:
        log: Of steps, of episodes, or of points, which are taken for episodes. Its start rows are no steps.
    """
    from harness.authoring.commands import episodes_of

    episodes, unknown = episodes_of(log), {}
    pays = {name: np.asarray(log[f"{REWARD}{name}"], np.float64) for name in episodes.returns}
    for name, paid in pays.items():
        if np.isnan(paid).any() or np.isnan(episodes.returns[name]).any():
            unknown[name] = episodes.reasons.get(f"{REWARD}{name}", NOT_KNOWN)
    known = [name for name in pays if name not in unknown]
    of_steps = {name: pays[name] for name in known} if log.facts.unit == "step" else {}
    return Paid(of_steps, {name: episodes.returns[name] for name in known}, unknown)


@dataclass(frozen=True)
class Apart:
    """How far apart two rewards are in one set of recorded steps. Scale and offset of a reward do not matter.

    Attributes:
        steps: Pearson distance of what they pay for each step, sqrt((1 - rho) / 2), in [0, 1]; None where one of them,
            and not the other, pays every step the same.
        returns: The same of the returns of finished episodes; None also below two of them.
        discordant: Share of the pairs of episodes that the two put in opposite orders, of those that both tell apart.
        told_apart: Share of all pairs of episodes that both tell apart; None below two episodes.
    """

    steps: float | None
    returns: float | None
    discordant: float | None
    told_apart: float | None


def compare_paid(paid: Paid, one: str, other: str) -> Apart:
    """How far apart two rewards are, both known in `paid`."""
    return Apart(
        _pearson(paid.steps, one, other), _pearson(paid.returns, one, other), *_order(paid.returns, one, other)
    )


def _pearson(values: Mapping[str, Float], one: str, other: str) -> float | None:
    if one not in values or len(values[one]) < 2:
        return None
    first, second = (centred_unit(values[name], float(np.abs(values[name]).max())) for name in (one, other))
    return distance_between(first, second)


def _order(returns: Mapping[str, Float], one: str, other: str) -> tuple[float | None, float | None]:
    """The shares of `Apart`. From Kendall's tau-b, which scipy finds without looking at all pairs."""
    from scipy.stats import kendalltau

    count = len(returns[one])
    pairs = count * (count - 1) // 2
    if not pairs:
        return None, None
    # Sums in another order differ in the last digits: such returns are equal.
    first, second = (_rounded(returns[name]) for name in (one, other))
    ties_one, ties_other = _ties(first), _ties(second)
    apart = pairs - ties_one - ties_other + _ties(np.stack([first, second], axis=1))
    if not apart:
        return None, 0.0
    tau = float(kendalltau(first, second).statistic)
    surplus = round(tau * float(np.sqrt(pairs - ties_one) * np.sqrt(pairs - ties_other)))
    return (apart - surplus) / 2 / apart, apart / pairs


def _rounded(values: Float) -> Float:
    unit = 1e-9 * float(np.abs(values).max())
    rounded: Float = np.round(values / unit) if unit else values
    return rounded


def _ties(values: Float) -> int:
    """How many pairs of rows are equal."""
    _, counts = np.unique(values, axis=0, return_counts=True)
    return int((counts.astype(np.int64) * (counts - 1) // 2).sum())
