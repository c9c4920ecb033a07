"""The questions of an audit: pure functions of what rewards paid, and of what behaviour was like.

Some can be asked of scripted movements alone, some of any episodes. `NOT_ASKED` says which a subject leaves open.
"""

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from harness.arrays import Float
from harness.audit.recorded.earned import Earned, best_paid
from harness.audit.score import Score, discounted_sum
from harness.audit.scripted import FINISH, HOLD
from harness.eta.auc import Auc, auc_of
from harness.log.log import SUCCESS
from harness.results.recordings.episodes import Episodes

ENVIRONMENT, RECORDED, LOGS = "environment", "recorded trainings", "logs"
"""What an audit is about, beside the scripted movements of an arm, of which everything is asked."""
NO_SCRIPTS = (
    "Not asked: whether finishing pays, and whether a reward is bounded, scale-free or shaping by a potential. Scripts "
    "and made-up distances ask that; they move an arm, and {} has none."
)
NO_FORMS = (
    "Not asked: EPIC, DARD and STARC. They ask a reward about other steps than those that were taken, and {} holds "
    "what rewards paid. harness audit TASK|ENVIRONMENT --reward NAME asks the rewards themselves."
)
NO_SUCCESS = (
    "Not asked: whether rewards rank episodes as success does. No measure that is 0 or 1 in every episode, such as "
    "success, was recorded."
)
NOT_RANKED = (
    "Not asked: whether rewards rank single episodes as success does. The measures of an arm are of a whole evaluation."
)
NOT_ASKED: Mapping[str, tuple[str, ...]] = {
    ENVIRONMENT: (NO_SCRIPTS.format("an environment"),),
    RECORDED: (NO_SCRIPTS.format("a recording"), NO_FORMS.format("a recording")),
    LOGS: (NO_SCRIPTS.format("a log"), NO_FORMS.format("a log")),
}
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


def deciding_measure(each: Sequence[Episodes]) -> str:
    """The measure that says which episodes succeeded: 0 or 1 in all of them; empty where there is none."""
    names = dict.fromkeys(name for episodes in each for name in episodes.behaviour)
    flags = [name for name in names if all(name in it.behaviour and it.is_flag(name) for it in each)]
    return SUCCESS if SUCCESS in flags else next(iter(flags), "")


def rank_success(
    each: Sequence[Episodes], reward: str, measure: str, trainings: Sequence[Hashable] | None = None
) -> Auc:
    """Whether a reward pays episodes that succeed more than those that fail.

    Args:
        each: Of each training, or of each evaluation of one.
        reward: One that is known in all of them.
        measure: Says which episodes succeeded; see `deciding_measure`.
        trainings: Which training each is of; a training of its own if None. Intervals are over these, and two
            evaluations of one are no two of them. The episodes of a single training count each by itself.
    """
    numbers: dict[Hashable, int] = {}
    owners = [numbers.setdefault(it, len(numbers)) for it in (range(len(each)) if trainings is None else trainings)]
    whose = [owner for owner, it in zip(owners, each, strict=True) for _ in it.last]
    paid, reached = (np.concatenate([of[name] for of in them]) for name, them in (
        (reward, [it.returns for it in each]), (measure, [it.behaviour for it in each])
    ))  # fmt: skip
    told = ~np.isnan(reached) & ~np.isnan(paid)
    clusters = np.asarray(whose)[told] if len(numbers) > 1 else None
    return auc_of(paid[told], reached[told] > 0.0, clusters)


def on_best(rows: Sequence[Earned], rewards: Sequence[str], measure: str) -> list[str]:
    """A line for each reward: whether it pays most for the behaviour that succeeds most.

    Args:
        rows: Behaviours that are compared; those of which the measure is not known say nothing.
        rewards: Names.
        measure: Of success.
    """
    known = [row for row in rows if measure and row.measures[measure].mean is not None]
    if len(known) < 2:
        return []
    good = max(known, key=lambda row: row.measures[measure].mean or 0.0)
    best, lines = good.measures[measure], []
    for name in rewards:
        paid = best_paid(known, name)
        if paid is None:
            continue
        success = paid.measures[measure]
        told = f"{paid.behaviour} ({measure} {success.mean:.3g})"
        if success.mean == best.mean:
            lines.append(f"{name} pays most for what succeeds most: {told}.")
            continue
        apart = success.high is not None and best.low is not None and success.high < best.low
        other = f"{good.behaviour} ({best.mean:.3g}){'' if apart else ', which may be chance'}"
        lines.append(f"{name} pays most for: {told}. What succeeds most is another behaviour: {other}.")
    return lines
