"""Whether the policy that an algorithm yields acts as it trained: against the actions that its training took.

At every observation a training draws its action around the one that its policy takes without noise: as often above it
as below, or, among choices, that one more often than any other. A policy that was put together wrongly from the
learner's network, with outputs in another order or without a bias, is not in the middle of what its training did.

An algorithm that tells its policy on the way, by `harness.progress.Progress.policy`, is compared at every step with the
policy of that step. Of one that does not, only the last steps are compared with what it yields in the end, roughly.
"""

from typing import Any, NamedTuple

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
FEWEST_TOGETHER = 6
MOST_TOGETHER = 2.5
"""The mean of the squares, in standard errors, over so many shares or more: together they tell more than one alone."""
FEWEST = 30
"""Actions that anything is concluded from."""
AT_THE_END = 1e-4
"""How near to an end of the box an action was clipped, and has nothing on its other side."""


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
        episodes = np.concatenate([_numbers_of_episodes(each) for each in compared])
        _require_median(done.astype(float), own.astype(float), episodes, tells)


def _numbers_of_episodes(decision: Decision) -> Any:
    """No two of different envs are alike, (num_envs,)."""
    return decision.episode * len(decision.episode) + np.arange(len(decision.episode))


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
    shares = [
        _share_above(done[:, number], own[:, number], where, episodes, f"action {number + 1}{part}")
        for number in range(own.shape[1])
        for part, where in _parts(own[:, number])
        if np.count_nonzero(where) >= FEWEST
    ]
    for share in shares:
        require(share.off <= max(MARGIN[tells], SURE[tells] * share.error), share.told)
    together = np.array([(share.off / share.error) ** 2 for share in shares])
    if tells and len(together) >= FEWEST_TOGETHER:
        worst = shares[int(together.argmax())]
        require(together.mean() <= MOST_TOGETHER, f"{worst.told}; the other actions are off too")


def _parts(own: Float) -> list[tuple[str, Mask]]:
    """Where an action of the policy is inside the box: large, and small."""
    inside: Mask = np.abs(own) < 1.0 - AT_THE_END
    middle = np.median(own[inside]) if inside.any() else 0.0
    return [(" where it is large", inside & (own > middle)), (" where it is small", inside & (own <= middle))]


class _Share(NamedTuple):
    """How far the share of actions above the policy's is off one half, its standard error, and that in words."""

    off: float
    error: float
    told: str


def _share_above(done: Float, own: Float, where: Mask, episodes: Any, name: str) -> _Share:
    done, own = done[where], own[where]
    above = float(np.where(done > own, 1.0, np.where(done < own, 0.0, 0.5)).mean())
    told = (
        f"{above:.0%} of the actions in training are above the policy's {name}, and half of them should be: it is "
        f"{own.mean():.2f} on average, in training {done.mean():.2f}; the policy does not act as it trained"
    )
    return _Share(abs(above - 0.5), _error_of_share(done - own, episodes[where]), told)


def _error_of_share(noise: Float, episodes: Any) -> float:
    """Standard error of the share of actions that are above: that of a coin, thrown as often as noise was drawn.

    Some learners draw noise anew in every step, some keep it for an episode. The intraclass correlation of the steps of
    an episode tells which.
    """
    _, numbers, counts = np.unique(episodes, return_inverse=True, return_counts=True)
    means = np.bincount(numbers, weights=noise) / counts
    total, within = float(noise.var()), float(((noise - means[numbers]) ** 2).mean())
    common = 1.0 - within / total if total > 0.0 else 1.0
    drawn = len(noise) / (1.0 + (counts.mean() - 1.0) * common)
    return float(0.5 / np.sqrt(drawn))
