"""Whether a word may be said of a reward that could not be paid every step.

What a reward would have paid there is not known. So it is tried how far the order of the episodes could move: the word
stands if it is the same at both ends.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Mask
from harness.authoring.commands import CANNOT_TELL, Auc, PaidDataset, auc_of
from harness.log import RECORDED

UNPAID = (
    "it looks at next_observation, which nothing tells after the last step. What it would pay there could change the "
    "order. A function that looks at observation, action and info alone is paid for every step"
)
DECIDES = "it cannot be paid the last step, and by that step the recorded reward gets another answer"
LOST = "it pays no finite number in some episodes, which could change the order"
OWN = "success is told by this very reward"


def answer_that_holds(
    auc: Auc, paid: PaidDataset, name: str, clusters: NDArray[np.int64], tasks: NDArray[np.int64]
) -> Auc:
    """The same, or without its word where what could not be paid might change it.

    A step that could not be paid pays no less and no more than the function pays any other step. But where success
    shows in that step alone, as where a function paid no finite number, it may pay anything.

    Args:
        auc: Of the episodes whose success is known and that were paid.
        paid: All of them.
        name: The reward.
        clusters: Of each episode.
        tasks: Of each episode.
    """
    unpaid, lost = paid.unpaid[name], paid.lost[name]
    if auc.answer == CANNOT_TELL or not (unpaid.any() or lost.any()):
        return auc
    if unpaid.any() and _last_step_decides(paid, clusters, tasks):
        return replace(auc, answer=CANNOT_TELL, reason=DECIDES)
    known, success = paid.known, paid.succeeded
    for best in (success, known & ~success):
        moved = _moved(paid, name, best)
        end = auc_of(moved[known], success[known], clusters[known], tasks[known])
        if end.answer != auc.answer:
            return replace(auc, answer=CANNOT_TELL, reason=UNPAID if unpaid.any() else LOST)
    return auc


def level_that_holds(
    auc: Auc, paid: PaidDataset, below: PaidDataset, name: str, clusters: NDArray[np.int64], tasks: NDArray[np.str_]
) -> Auc:
    """The same of a data set above that of a beginner; see `answer_that_holds`."""
    torn = any((it.unpaid[name] | it.lost[name]).any() for it in (paid, below))
    if auc.answer == CANNOT_TELL or not torn:
        return auc
    above = np.arange(len(paid) + len(below)) < len(paid)
    for best in (True, False):
        sides = ((paid, best), (below, not best))
        moved = np.concatenate([_moved(it, name, np.full(len(it), most)) for it, most in sides])
        if auc_of(moved, above, clusters, tasks).answer != auc.answer:
            return replace(auc, answer=CANNOT_TELL, reason=UNPAID if paid.unpaid[name].any() else LOST)
    return auc


def of_its_own_return(auc: Auc, paid: PaidDataset, name: str) -> Auc:
    """Without a word where the recorded return is both what succeeds and what is asked about."""
    if paid.by_return and name == RECORDED and auc.answer != CANNOT_TELL:
        return replace(auc, answer=CANNOT_TELL, reason=OWN)
    return auc


def _moved(paid: PaidDataset, name: str, best: Mask) -> Float:
    """What each episode is paid where what is not known is the most for some, and the least for all others."""
    steps = paid.paid[name]
    seen = steps[~np.isnan(steps)]
    unpaid, returns = paid.unpaid[name], paid.returns[name]
    moved = returns + np.where(unpaid, np.where(best, seen.max(initial=0.0), seen.min(initial=0.0)), 0.0)
    anything = paid.lost[name] | (unpaid & paid.shown_last)
    far = 1.0 + float(np.ptp(moved))
    return np.where(anything, np.where(best, moved.max() + far, moved.min() - far), moved)


def _last_step_decides(paid: PaidDataset, clusters: NDArray[np.int64], tasks: NDArray[np.int64]) -> bool:
    """Whether the recorded reward would get another answer without its last steps."""
    whole, last = paid.recorded.T
    known, success = paid.known, paid.succeeded
    if np.isnan(whole).any():
        return False
    answers = (auc_of(it[known], success[known], clusters[known], tasks[known]).answer for it in (whole, whole - last))
    return len({*answers}) > 1


def lines_of(paid: PaidDataset, name: str) -> tuple[str, ...]:
    """What is told of the steps that it could not be paid, a line each."""
    lines = []
    unpaid, lost = paid.unpaid[name], paid.lost[name]
    if unpaid.any():
        lines.append(f"not paid the last step of {int(unpaid.sum()):,} episodes, since it looks at what came then")
    if lost.any():
        first = int(paid.numbers[lost][0])
        lines.append(
            f"left out of this answer, since it pays no finite number there: {int(lost.sum()):,} episodes "
            f"(the first is {first})"
        )
    return tuple(lines)
