"""Whether the policy that an algorithm yields acts as it trained: against the actions that its training took.

At every observation a training draws its action around the one that its policy takes without noise: as often above it
as below, or, among choices, that one more often than any other. A policy that was put together wrongly from the
learner's network, with outputs in another order or without a bias, is not in the middle of what its training did.

An algorithm that tells its policy on the way, by `harness.progress.Progress.policy`, is compared at every step with the
policy of that step. Of one that does not, only the last steps are compared with what it yields in the end, roughly.
"""

from typing import Any

import numpy as np

from harness.arrays import Float, Mask
from harness.policy import Policy
from harness.testing.trainings import Decision, Training
from harness.testing.violations import require

COMPARED = {True: 0.6, False: 0.25}
"""The share of a training that is compared, at its end: where it tells its policy on the way, and where not."""
MARGIN = {True: 0.08, False: 0.25}
"""By how much the share of actions above the policy's may be off one half."""
SURE = {True: 4.5, False: 6.0}
"""Standard errors that it has to be off besides."""
FEWEST = 30
"""Actions that anything is concluded from."""
AT_THE_END = 1e-4
"""Of the box: an action so near to an end of it was clipped, and has nothing on its other side."""


def require_in_the_middle(training: Training) -> None:
    """Raise AssertionError where the training took actions that its policy is not in the middle of."""
    tells, decisions = training.tells_its_policy, training.env.decisions
    kept = decisions[len(decisions) - int(COMPARED[tells] * len(decisions)) :]
    compared = [each for each in kept if each.policy is not None or not tells]
    if not compared:
        return
    done = np.concatenate([each.action for each in compared])
    own = np.concatenate([_own_action(each, training.policy) for each in compared])
    if training.env.space == "discrete":
        _require_most_frequent(done, own, tells)
    else:
        episodes = np.concatenate([each.episode * len(each.episode) + np.arange(len(each.episode)) for each in compared])
        _require_median(done.astype(float), own.astype(float), episodes, tells)


def _own_action(decision: Decision, last: Policy) -> Any:
    return (decision.policy or last).act(decision.observation)


def _require_most_frequent(done: Any, own: Any, tells: bool) -> None:
    """Where the policy would choose k, the training chose nothing else far more often than k."""
    for choice in np.unique(own):
        counts = np.bincount(done[own == choice], minlength=int(choice) + 1)
        total, most = counts.sum(), int(counts.argmax())
        ahead = (counts[most] - counts[choice]) / total
        sure = ahead > SURE[tells] / np.sqrt(total) and ahead > MARGIN[tells]
        require(
            total < FEWEST or not sure,
            f"where the policy chooses {choice}, the training chose {most} in {counts[most]} of {total} steps and "
            f"{choice} in {counts[choice]}: the policy is not the one that was trained",
        )


def _require_median(done: Float, own: Float, episodes: Any, tells: bool) -> None:
    """Training actions are as often above the policy's as below, where that one is large and where it is small."""
    for number in range(own.shape[1]):
        inside = np.abs(own[:, number]) < 1.0 - AT_THE_END
        middle = np.median(own[inside, number]) if inside.any() else 0.0
        for part, where in (("", inside), (" where it is large", inside & (own[:, number] > middle)),
                            (" where it is small", inside & (own[:, number] <= middle))):  # fmt: skip
            _require_half(done[:, number], own[:, number], where, episodes, f"action {number + 1}{part}", tells)


def _require_half(done: Float, own: Float, where: Mask, episodes: Any, name: str, tells: bool) -> None:
    if np.count_nonzero(where) < FEWEST:
        return
    above = np.where(done > own, 1.0, np.where(done < own, 0.0, 0.5))[where]
    share, error = _mean_over_episodes(above, episodes[where])
    off = abs(share - 0.5)
    require(
        off <= MARGIN[tells] or off <= SURE[tells] * error,
        f"{share:.0%} of the actions in training are above the policy's {name}, which is {own[where].mean():.2f} on "
        f"average, in training {done[where].mean():.2f}; half of them should be: the policy does not act as it trained",
    )


def _mean_over_episodes(values: Float, episodes: Any) -> tuple[float, float]:
    """The mean, and its standard error; noise may last for an episode, so that episodes count and not steps."""
    names, numbers = np.unique(episodes, return_inverse=True)
    counts = np.bincount(numbers)
    mean = float(values.mean())
    sums = np.bincount(numbers, weights=values - mean)
    if len(names) < 2:
        return mean, np.inf
    # Of a mean of clusters of unequal size.
    error = np.sqrt((sums**2).sum() * len(names) / (len(names) - 1)) / counts.sum()
    return mean, float(error)
