"""How much of the change of a mean return is ruler, and how much is behaviour, in any environment.

With R_r(q) the mean return of the trainings by reward q, paid by reward r (B baseline, K proposed), the sum

    R_K(K) - R_B(B) = ruler + behaviour

is always defined; ``docs/what-eta-is.md`` says how. The ratio is, where all four returns are above 0.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import comb, sqrt
from typing import Any

import numpy as np

from harness.arrays import Float
from harness.eta.decomposition import OWNER, Splitter, noise_of_means, split_sum
from harness.eta.index import Ratio, SeedMean, mean_over_seeds
from harness.eta.interval import ROUNDING, quantile
from harness.eta.splits import BB, BK, KB, KK, Pair, ScoredSums, Split, SumSplit, means_without_each
from harness.eta.swaps import Swaps, p_of

LEVEL = 0.05
"""The chance of a wrong claim, at most."""
OF_RANDOM = 0.01
"""The part of it that is spent on the mean of random actions."""


@dataclass(frozen=True)
class PaidAtRandom:
    """What a reward pays its own policies, and what it pays random actions in the same episodes.

    Attributes:
        reward: The label of the reward.
        trained: The mean return of an episode, of each training.
        at_random: The mean return of an episode of random actions.
        least: The mean of random actions lies above this, but for a chance of `OF_RANDOM`.
    """

    reward: str
    trained: tuple[float, ...]
    at_random: float
    least: float

    @property
    def below(self) -> int:
        """How many trainings are paid less than random actions, by more than rounding."""
        return sum(it < self.least - ROUNDING * abs(self.least) for it in self.trained)

    @property
    def p(self) -> float:
        """How often so many or more are below where a training is as likely above."""
        count = len(self.trained)
        return float(sum(comb(count, it) for it in range(self.below, count + 1)) / 2**count)

    @property
    def is_below(self) -> bool:
        """Whether most trainings are paid less than random actions, by more than chance."""
        return self.p <= LEVEL - OF_RANDOM

    @property
    def told(self) -> str:
        """The claim in words; empty where it cannot be made."""
        if not self.is_below:
            return ""
        count, mean = len(self.trained), float(np.mean(self.trained))
        below = f"all {count}" if self.below == count else f"{self.below} of {count}"
        return (
            f"{self.reward} was not maximised: it pays random actions more than the policies of {below} trainings "
            f"({_digits(self.at_random)} an episode; after training {_digits(mean)} on average). So this comparison "
            f"says nothing about what {self.reward} asks for. The test is made to err in at most {LEVEL:.0%} of cases."
        )

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "reward": self.reward,
            "trained": list(self.trained),
            "random": self.at_random,
            "below": self.below,
            "p": self.p,
        }


def paid_at_random(reward: str, trained: Sequence[float], episodes: Float) -> PaidAtRandom | None:
    """What a reward pays beside random actions; None without two episodes of these, or without a training.

    Args:
        reward: The label of the reward.
        trained: The mean return of an episode, of each training by this reward.
        episodes: The returns of random actions, (episodes,).
    """
    if len(episodes) < 2 or not trained:
        return None
    mean, error = float(episodes.mean()), float(episodes.std(ddof=1)) / sqrt(len(episodes))
    reach = quantile(1.0 - 2.0 * OF_RANDOM, len(episodes) - 1) * error
    return PaidAtRandom(reward, tuple(trained), mean, mean - reach)


def _digits(value: float) -> str:
    """A number with four digits, without an exponent up to a million."""
    return f"{float(f'{value:.4g}'):,.6g}"


NAME = "mean return"

Returns = Mapping[Pair, Sequence[float]]
"""R_r(q) of each seed by (r, q): the reward that scores, and the reward whose training is scored."""


@dataclass(frozen=True)
class ReturnSplit:
    """The mean return of two trainings.

    Attributes:
        returns: R_r(q) over seeds, by (r, q).
        ratio: eta = R_K(K) / R_B(B), and its parts; without a value if a return is not above 0.
        total: R_K(K) - R_B(B), and its parts.
    """

    returns: Mapping[Pair, SeedMean]
    ratio: Split
    total: SumSplit

    @property
    def is_split(self) -> bool:
        """Whether each training was paid by the other's reward."""
        return {BK, KB} <= self.returns.keys()

    @property
    def has_ratio(self) -> bool:
        """Whether the ratio says something; where it does not, the difference is told."""
        eta = self.ratio.eta
        return eta.value is not None and eta.value > 0.0 and eta.near_zero is None

    def with_corrected(self, p: float | None) -> "ReturnSplit":
        """The same split with a p-value that holds for all claims that are made together."""
        return replace(self, ratio=replace(self.ratio, corrected=p))

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "returns": [
                {"paid_by": payer, "trained_by": trained, **mean.to_json()}
                for (payer, trained), mean in self.returns.items()
            ],
            "ratio": self.ratio.to_json(),
            "difference": self.total.to_json(),
        }


def split_returns(
    returns: Returns, seeds: Sequence[int], swaps: Swaps | None, missing: str | None = None
) -> ReturnSplit:
    """Both splits, with intervals over seeds.

    Args:
        returns: At least of (baseline, baseline) and (proposed, proposed), one finite value per seed.
        seeds: The seeds of the values; seed i of both trainings is a pair.
        swaps: The ways in which the names of a seed's trainings are swapped; None if no claim is made.
        missing: Why the other two are not there; None where they are.
    """
    each = {pair: np.asarray(values, np.float64) for pair, values in returns.items()}
    sums = ScoredSums(
        {pair: np.array([values.mean()]) for pair, values in each.items()},
        {pair: means_without_each(values) for pair, values in each.items()},
        each,
        paired=True,
    )
    is_claim = swaps is not None and len(seeds) > 1
    outcomes = swaps.of(seeds) @ (each[KK] - each[BB]) / len(seeds) if swaps and is_claim else None
    return ReturnSplit(
        {pair: mean_over_seeds(values.tolist()) for pair, values in each.items()},
        _split_ratio(sums, outcomes, missing),
        split_sum(sums, missing),
    )


def _split_ratio(sums: ScoredSums, outcomes: Float | None, missing: str | None) -> Split:
    small = next((pair for pair in sums.whole if sums.value(pair) <= 0.0), None)
    if small is not None:
        reason = f"the {NAME} of {OWNER[small]} is not above 0, and a ratio would say nothing: see the difference"
        nothing = Ratio(None, notes=(reason,))
        p = None if outcomes is None else p_of(outcomes)
        return Split(nothing, nothing, nothing, nothing, nothing, noise=nothing, p=p, outcomes=outcomes)
    split = Splitter(f"the {NAME}", _positive(sums)).split(outcomes, missing)
    return replace(split, noise=noise_of_means(sums.each[BB]))


def _positive(sums: ScoredSums) -> ScoredSums:
    """The sums with NaN for values that are not above 0. Two negative values would give a ratio like any other."""
    without = {pair: np.where(values > 0.0, values, np.nan) for pair, values in sums.without.items()}
    return replace(sums, without=without)
