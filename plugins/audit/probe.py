"""Made-up distances: a reward is asked about what no scripted policy does as well, if it needs no more than them."""

from collections.abc import Sequence

import numpy as np

from harness import Float
from harness.payoff.rollout import Score, States, pay_along
from harness.reward import Reward
from harness.reward.steps import DISTANCE, MissingField

EACH = 16
"""Episodes of each of the three kinds."""


def probe_distances(low: float, high: float, steps: int = 100) -> Float:
    """Distances of made-up episodes, log-uniform between `low` and `high` [m]; the same at every call.

    A third jumps at random, a third wanders in small steps, a third comes nearer at every step.

    Returns:
        (steps + 1, 48), [m].
    """
    rng = np.random.default_rng(0)
    jumps, approach = rng.uniform(0.0, 1.0, (2, steps + 1, EACH))
    wander = np.cumsum(rng.normal(0.0, 0.05, (steps + 1, EACH)), axis=0) + rng.uniform(0.0, 1.0, EACH)
    folded = np.abs((wander + 1.0) % 2.0 - 1.0)  # reflected at both ends
    parts = [jumps, folded, -np.sort(-approach, axis=0)]
    distances: Float = low * (high / low) ** np.concatenate(parts, axis=1)
    return distances


def needed_beside_distances(reward: Reward, scores: Sequence[Score]) -> tuple[str, ...]:
    """Fields without which a reward fails in recorded steps, or pays something else; none if distances are enough.

    Of one that pays something else whenever it is asked, only those without which it fails.

    Args:
        reward: What is asked.
        scores: What it paid in the rollouts.
    """
    names = [name for name in scores[0].rollout.states if name != DISTANCE]
    is_function = _pays_without([], reward, scores, alike=True)
    if _pays_without(names, reward, scores, alike=is_function):
        return ()
    return tuple(name for name in names if not _pays_without([name], reward, scores, alike=is_function))


def _pays_without(names: Sequence[str], reward: Reward, scores: Sequence[Score], *, alike: bool) -> bool:
    """Whether a reward pays without these fields; if `alike`, what it paid with them."""

    def pays(score: Score) -> bool:
        states: States = {name: values for name, values in score.rollout.states.items() if name not in names}
        paid, running = pay_along(reward, states).total, score.rollout.running
        return not alike or np.array_equal(paid[running], score.values[running])

    try:
        return all(map(pays, scores))
    except MissingField:
        return False
