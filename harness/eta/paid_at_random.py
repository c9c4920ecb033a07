"""Whether a reward pays the policies that it trained less than random actions: then it was not maximised.

The claim is about most trainings: a policy that is trained once more is more likely paid less than random actions are
on average than not. Two errors can make it wrong, and both together have a chance of at most `LEVEL`. The mean of
random actions is taken to be its lower bound, by Student's t over episodes, which is too high with a chance of
`OF_RANDOM`. Then the trainings below that bound are counted, and the sign test says how often so many would be if a
training were as likely above as below. It holds whatever the distribution of trainings is, also where few of them
learn. Fewer than five trainings make no claim.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import comb, sqrt
from typing import Any

import numpy as np

from harness.arrays import Float
from harness.eta.interval import ROUNDING, quantile

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
