"""Whether finishing is what a reward pays for: what it paid the scripted policies, and that in plain words."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np

from harness.arrays import Float
from harness.payoff.rollout import FINISH, HOLD
from harness.payoff.score import Score, discounted_sum
from harness.text import number

SLACK = 1e-9
"""Returns that differ by no more than this share of the largest are equal."""


MARGIN = 0.05
"""With noise on the actions something else has to earn more than finishing by this share of all that is earned."""


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
        terms: The sum of what each term of the reward paid in an episode, in their order; none if it has none.
    """

    policy: str
    success: float
    steps: float
    shaped: float
    total: float
    shaped_discounted: float
    total_discounted: float
    terms: Mapping[str, float]

    def to_json(self) -> dict[str, Any]:
        """Plain data; a reward without terms has none there."""
        return {name: value for name, value in asdict(self).items() if name != "terms" or value}


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


@dataclass(frozen=True)
class Finishing:
    """What a reward pays the scripted policies, and whether finishing is what pays.

    Attributes:
        gamma: Discount of the discounted figures.
        payoffs: One of each scripted policy, the best return first.
        undiscounted: What pays more than finishing, without discount.
        discounted: The same with it.
        holding_pays: Whether standing still at the start does.
        steps: How many steps the policies took in all.
        never_paid: The terms that paid nothing in any of them.
    """

    gamma: float
    payoffs: tuple[Payoff, ...]
    undiscounted: tuple[Temptation, ...]
    discounted: tuple[Temptation, ...]
    holding_pays: bool
    steps: int
    never_paid: tuple[str, ...]


class UnderNoise(NamedTuple):
    """What pays more than finishing, while every action is disturbed."""

    policy: str
    earns: float
    """Its mean return; discounted where it pays more with a discount alone."""
    finish_earns: float
    is_robust: bool
    """Whether it still earns more, by more than a margin."""


def under_noise(of: Finishing, disturbed: Finishing) -> UnderNoise:
    """Whether what pays more than finishing still does while actions are disturbed.

    Args:
        of: What the scripts earn; something earns more than finishing.
        disturbed: What they earn with noise on their actions.
    """
    plain, noisy = (
        {it.policy: it.total if of.undiscounted else it.total_discounted for it in found.payoffs}
        for found in (of, disturbed)
    )
    margin = MARGIN * (max(plain.values()) - min(plain.values()))
    best = max((it.policy for it in of.undiscounted or of.discounted), key=noisy.__getitem__)
    return UnderNoise(best, noisy[best], noisy[FINISH], noisy[best] > noisy[FINISH] + margin)


def finishing_of(scores: Sequence[Score], gamma: float) -> Finishing:
    """What a reward pays for.

    Args:
        scores: What it paid in one rollout of each script.
        gamma: The learner's discount per step, in (0, 1].
    """
    payoffs = [payoff_of(score, gamma) for score in scores]
    return Finishing(
        gamma,
        tuple(sorted(payoffs, key=lambda payoff: -payoff.total)),
        tuple(temptations(scores, 1.0)),
        tuple(temptations(scores, gamma)),
        holding_pays(payoffs),
        sum(int(score.rollout.running.sum()) for score in scores),
        never_paid(scores),
    )


def payoff_of(score: Score, gamma: float) -> Payoff:
    """The means of a scored rollout."""
    rollout = score.rollout
    return Payoff(
        rollout.script,
        float(rollout.reached.mean()),
        float(rollout.steps.mean()),
        shaped=_mean_return(score.values, 1.0),
        total=_mean_return(score.paid, 1.0),
        shaped_discounted=_mean_return(score.values, gamma),
        total_discounted=_mean_return(score.paid, gamma),
        terms={name: _mean_return(values, 1.0) for name, values in score.terms.items()},
    )


def never_paid(scores: Sequence[Score]) -> tuple[str, ...]:
    """The terms of a reward that paid 0 in every step of every script."""
    return tuple(name for name in scores[0].terms if not any(score.terms[name].any() for score in scores))


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


def _mean_return(values: Float, gamma: float) -> float:
    return float(discounted_sum(values, gamma).mean())


def on_finishing(of: Finishing) -> str:
    """Whether finishing is what pays; rests on the discounted return, which is what a learner is after."""
    rate, plain, discounted = f"discounted by {of.gamma:g}", of.undiscounted, of.discounted
    if plain and discounted:
        told = f"{_compare(plain[0])}; {rate} {_compare(discounted[0])}"
        return f"Not finishing pays more than finishing: {told}."
    if discounted:
        return f"Not finishing pays more than finishing: {rate} {_compare(discounted[0])}; without discount less."
    if plain:
        return f"Finishing pays most {rate}; without discount it does not: {_compare(plain[0])}."
    finish = next(payoff for payoff in of.payoffs if payoff.policy == FINISH)
    others = [payoff for payoff in of.payoffs if payoff.success < finish.success]
    beside = f", {others[0].policy} {number(others[0].total)}" if others else ""
    return f"Finishing pays most: finish earns {number(finish.total)} per episode{beside}."


def on_terms(of: Finishing) -> list[str]:
    """A line for each term that paid nothing in all these steps of the scripted policies."""
    return [f"The term '{name}' never paid in {of.steps:,} steps." for name in of.never_paid]


def _compare(temptation: Temptation) -> str:
    return (
        f"{temptation.policy} earns {number(temptation.earns)} per episode, finish {number(temptation.finish_earns)}"
        f" (more in {temptation.share:.0%} of the episodes)"
    )
