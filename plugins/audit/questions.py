"""The questions of an audit: pure functions of what rewards paid, and of what behaviour was like.

Some can be asked of scripted movements alone, some of any episodes. A line says which a subject leaves open.
"""

from collections.abc import Hashable, Sequence

import numpy as np

from harness.eta import auc_of
from harness.eta.auc import Auc
from harness.log.log import SUCCESS
from harness.results.recordings.episodes import Episodes

from .recorded.earned import Earned, best_paid

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
    known = [row for row in rows if measure and row.measures[measure].value is not None]
    if len(known) < 2:
        return []
    good = max(known, key=lambda row: row.measures[measure].value or 0.0)
    best, lines = good.measures[measure], []
    for name in rewards:
        paid = best_paid(known, name)
        if paid is None:
            continue
        success = paid.measures[measure]
        told = f"{paid.behaviour} ({measure} {success.value:.3g})"
        if success.value == best.value:
            lines.append(f"{name} pays most for what succeeds most: {told}.")
            continue
        apart = success.high is not None and best.low is not None and success.high < best.low
        other = f"{good.behaviour} ({best.value:.3g}){'' if apart else ', which may be chance'}"
        lines.append(f"{name} pays most for: {told}. What succeeds most is another behaviour: {other}.")
    return lines
