"""What several rewards paid for the same steps, and how far apart two of them are in that."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from harness.arrays import Float
from harness.audit.unit_vectors import centred_unit, distance_between

if TYPE_CHECKING:  # recordings are not loaded where a data set is audited
    from harness.record.recording.recorded_training import RecordedTraining
    from harness.results.recordings.episodes import Episodes


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

    def __add__(self, other: "Paid") -> "Paid":
        """The steps of both, by rewards that are known in both."""
        both = [name for name in self.steps if name in other.steps]
        return Paid(
            {name: np.concatenate([self.steps[name], other.steps[name]]) for name in both},
            {name: np.concatenate([self.returns[name], other.returns[name]]) for name in both},
            {**other.unknown, **self.unknown},
        )


def paid_in(recording: "RecordedTraining", episodes: "Episodes") -> Paid:
    """What the rewards of a recording paid, in its steps and in its finished episodes."""
    from harness.record.recording.facts import REWARD

    unknown = {
        name: episodes.reasons.get(f"{REWARD}{name}", "not a number in some steps")
        for name, values in recording.rewards.items()
        if f"{REWARD}{name}" in episodes.reasons or np.isnan(values).any()
    }
    known = [name for name in recording.rewards if name not in unknown]
    return Paid(
        {name: recording.rewards[name] for name in known}, {name: episodes.returns[name] for name in known}, unknown
    )


class EpisodeOrder(NamedTuple):
    """How two rewards order the same episodes."""

    discordant: float | None
    """Share of the pairs of episodes that the two put in opposite orders, of those that both tell apart."""
    told_apart: float | None
    """Share of all pairs of episodes that both tell apart; None below two episodes."""


@dataclass(frozen=True)
class Apart:
    """How far apart two rewards are in one set of recorded steps. Scale and offset of a reward do not matter.

    Attributes:
        steps: Pearson distance of what they pay for each step, sqrt((1 - rho) / 2), in [0, 1]; None where one of them,
            and not the other, pays every step the same.
        returns: The same of the returns of finished episodes; None also below two of them.
        order: How they order these episodes.
    """

    steps: float | None
    returns: float | None
    order: EpisodeOrder


def compare_paid(paid: Paid, one: str, other: str) -> Apart:
    """How far apart two rewards are, both known in `paid`."""
    return Apart(_pearson(paid.steps, one, other), _pearson(paid.returns, one, other), _order(paid.returns, one, other))


def pairs_of(names: tuple[str, ...]) -> list[tuple[str, str]]:
    """Every two of them once."""
    return list(combinations(names, 2))


def _pearson(values: Mapping[str, Float], one: str, other: str) -> float | None:
    if len(values[one]) < 2:
        return None
    first, second = (centred_unit(values[name], float(np.abs(values[name]).max())) for name in (one, other))
    return distance_between(first, second)


def _order(returns: Mapping[str, Float], one: str, other: str) -> EpisodeOrder:
    """From Kendall's tau-b, which scipy finds without looking at every pair."""
    from scipy.stats import kendalltau

    count = len(returns[one])
    pairs = count * (count - 1) // 2
    if not pairs:
        return EpisodeOrder(None, None)
    # Sums in another order differ in the last digits: such returns are equal.
    first, second = (_rounded(returns[name]) for name in (one, other))
    ties_one, ties_other = _ties(first), _ties(second)
    apart = pairs - ties_one - ties_other + _ties(np.stack([first, second], axis=1))
    if not apart:
        return EpisodeOrder(None, 0.0)
    tau = float(kendalltau(first, second).statistic)
    surplus = round(tau * float(np.sqrt(pairs - ties_one) * np.sqrt(pairs - ties_other)))
    return EpisodeOrder((apart - surplus) / 2 / apart, apart / pairs)


def _rounded(values: Float) -> Float:
    unit = 1e-9 * float(np.abs(values).max())
    rounded: Float = np.round(values / unit) if unit else values
    return rounded


def _ties(values: Float) -> int:
    """How many pairs of rows are equal."""
    _, counts = np.unique(values, axis=0, return_counts=True)
    return int((counts.astype(np.int64) * (counts - 1) // 2).sum())
