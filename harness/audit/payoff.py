"""What each scripted policy earns under a reward, and whether finishing is what pays."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from harness.audit.score import Score, discounted_sum
from harness.audit.scripted import FINISH, HOLD

SLACK = 1e-9
"""Returns that differ by no more than this share of the largest are equal."""


@dataclass(frozen=True)
class Payoff:
    """Means over the episodes of one script.

    Attributes:
        policy: The script.
        success: Share of episodes that ended at the target.
        steps: Length of an episode.
        shaped: Sum of the shaped reward of an episode.
        total: The same with the event terms.
        shaped_discounted: The sum of gamma^t times the shaped reward.
        total_discounted: The same with the event terms.
    """

    policy: str
    success: float
    steps: float
    shaped: float
    total: float
    shaped_discounted: float
    total_discounted: float


@dataclass(frozen=True)
class Temptation:
    """A policy that does not finish and earns more than the one that does, event terms included.

    Attributes:
        policy: The script.
        gamma: Discount per step.
        earns: Its mean return.
        finish_earns: That of ``finish``.
        share: Of the episodes in which it earns more.
    """

    policy: str
    gamma: float
    earns: float
    finish_earns: float
    share: float

    @property
    def margin(self) -> float:
        """By how much it earns more."""
        return self.earns - self.finish_earns


def payoff_of(score: Score, gamma: float) -> Payoff:
    """The means of a scored rollout."""
    rollout = score.rollout
    sums = [discounted_sum(values, rate).mean() for rate in (1.0, gamma) for values in (score.values, score.paid)]
    return Payoff(rollout.script, float(rollout.reached.mean()), float(rollout.steps.mean()), *map(float, sums))


def temptations(scores: Sequence[Score], gamma: float) -> list[Temptation]:
    """The scripts that reach the target less often than ``finish`` and earn more, the best first."""
    returns = {score.rollout.script: discounted_sum(score.paid, gamma) for score in scores}
    success = {score.rollout.script: score.rollout.reached.mean() for score in scores}
    finish = returns[FINISH]
    slack = SLACK * max(np.abs(values).mean() for values in returns.values())
    found = [
        Temptation(name, gamma, float(earned.mean()), float(finish.mean()), float((earned > finish + slack).mean()))
        for name, earned in returns.items()
        if success[name] < success[FINISH] and earned.mean() > finish.mean() + slack
    ]
    return sorted(found, key=lambda temptation: -temptation.margin)


def holding_pays(payoffs: Sequence[Payoff]) -> bool:
    """Whether the shaped reward of standing still at the start adds up to more than nothing, discounted or not."""
    largest = max(max(abs(payoff.shaped), abs(payoff.shaped_discounted)) for payoff in payoffs)
    hold = next(payoff for payoff in payoffs if payoff.policy == HOLD)
    return max(hold.shaped, hold.shaped_discounted) > 1e-3 * largest
