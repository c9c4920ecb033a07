"""Rewards in a form that scale alone sets apart: offset and potential shaping are gone from it.

These forms are for rewards that read distances alone; see `harness_plugins.audit.transitions.rollout_forms` for the
others. A state is what a step begins with: distance d, smallest distance so far, begin distance, step count and carry.
The next state follows from the state and the next distance d' alone, so that a reward is a function R(s, d'). There are
two forms:

    EPIC (Gleave et al. 2021)   C(s, s') = R(s, d') + gamma E[R(s', D)] - E[R(s, D)]
    DARD (Wulfe et al. 2022)    C(s, s') = R(s, d') + E[gamma R(s', D'') - R(s, D') - gamma R(S', D'')]

EPIC's D is any distance that was recorded, also one that no step from s leads to. EPIC's last term, the mean of R over
the coverage, is the same for all transitions and drops out of a correlation. DARD's D' is the distance after a step
from s, and S' the state there; D'' is the distance after a step from s'. Both steps change the distance as recorded
steps from nearby did.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.authoring.commands import DISTANCE, Rollout, paid_along, rows_of, step_between
from harness.reward import Carry, Reward, Steps, pay

from .distance import DARD, EPIC, Form, centred_unit

SAMPLES = 64
"""So many distances stand for EPIC's D."""

GROUPS = 32
"""Recorded steps that began at about the same distance are a group; so many groups of about the same size."""

CHANGES = 16
"""So many changes of the distance stand for those of a group."""


class Expectation(Protocol):
    """What steps other than the one taken would pay, on average."""

    def __call__(self, reward: Reward, carry: Carry, step: Steps) -> tuple[Float, Float]:
        """E[R(s, D')], and E[R(S', D'')] where the form has that term, 0 where it has not; each (n,).

        Args:
            reward: R.
            carry: What is remembered in s.
            step: The one from s that was taken; it led to s'.
        """


@dataclass(frozen=True, eq=False)
class Anywhere:
    """EPIC's: a step may lead to any recorded distance.

    Attributes:
        distances: The distances that stand for all, (SAMPLES,), [m].
    """

    distances: Float

    def __call__(self, reward: Reward, carry: Carry, step: Steps) -> tuple[Float, Float]:
        """The second is 0: EPIC's last term is a constant."""
        count, size = len(self.distances), len(step.distance)
        led = _leading_to(rows_of(step, _each(size, count)), np.tile(self.distances, size))
        return _mean(pay(reward, _repeated(carry, count), led)[1].total, count), np.zeros(size)


@dataclass(frozen=True, eq=False)
class Nearby:
    """DARD's: a step changes the distance as a recorded step from nearby did.

    DARD averages over actions A, and both steps of a pair, from s and from s', take the same one. Here A says which of
    a group's changes it is, counted from the largest approach.

    Attributes:
        edges: Distance at which each group begins, but for the first, (groups - 1,), [m].
        changes: Quantiles of the changes of each group, (groups, CHANGES), [m].
        lowest: Smallest distance that a recorded step led to, [m]; no step leads below it.
    """

    edges: Float
    changes: Float
    lowest: float

    def __call__(self, reward: Reward, carry: Carry, step: Steps) -> tuple[Float, Float]:
        """One step from s, and one from where it leads."""
        near = self.after(step.previous_distance).ravel()
        first = _leading_to(rows_of(step, _each(len(step.distance), CHANGES)), near)
        remembered, here = pay(reward, _repeated(carry, CHANGES), first)
        _, beyond = pay(reward, remembered, _following(first, self.after(step.distance).ravel()))
        return _mean(here.total, CHANGES), _mean(beyond.total, CHANGES)

    def after(self, distance: Float) -> Float:
        """Distances after a step from `distance`, (n,), one for each A, (n, CHANGES), [m]."""
        group = np.searchsorted(self.edges, distance, side="right")
        after: Float = np.maximum(distance[:, None] + self.changes[group], self.lowest)
        return after


def anywhere(rollouts: Sequence[Rollout]) -> Anywhere:
    """Quantiles of the distances after the recorded steps of all scripts, each step weighing the same."""
    _, after = _recorded(rollouts)
    return Anywhere(np.quantile(after, _levels(SAMPLES)))


def nearby(rollouts: Sequence[Rollout]) -> Nearby:
    """Quantiles of the changes in the recorded steps of all scripts, by the distance before the step."""
    before, after = _recorded(rollouts)
    begins = np.unique(np.quantile(before, np.arange(GROUPS) / GROUPS, method="lower"))
    # A group begins at a recorded distance, so none is empty.
    group = np.searchsorted(begins[1:], before, side="right")
    change = after - before
    changes = [np.quantile(change[group == number], _levels(CHANGES)) for number in range(len(begins))]
    return Nearby(begins[1:], np.stack(changes), float(after.min()))


Coverage: TypeAlias = Callable[[Sequence[Rollout]], Expectation]
"""`anywhere` or `nearby`: where steps may lead, from what was recorded."""


def forms_of_distances(reward: Reward, rollouts: Sequence[Rollout], gamma: float) -> dict[str, Form]:
    """A reward of distances alone in EPIC's form and in DARD's, over all recorded steps.

    Args:
        reward: The reward.
        rollouts: One of each script.
        gamma: Discount per step.
    """
    coverages: dict[str, Coverage] = {EPIC: anywhere, DARD: nearby}
    return {form: centred_unit(*canonical_values(reward, rollouts, gamma, of)) for form, of in coverages.items()}


def canonical_values(
    reward: Reward, rollouts: Sequence[Rollout], gamma: float, coverage: Coverage
) -> tuple[Float, float]:
    """C of every recorded step, (transitions,), and the largest value that the reward paid for one."""
    expectation = coverage(rollouts)
    shaped, largest = [], 0.0
    for rollout in rollouts:
        paid, expected, beyond = _terms(reward, rollout.distances, expectation)
        values = paid[:-1] + gamma * expected[1:] - expected[:-1] - gamma * beyond[:-1]
        shaped.append(values[rollout.running])
        largest = max(largest, float(np.abs(paid[:-1][rollout.running]).max()))
    return np.concatenate(shaped), largest


def _terms(reward: Reward, distances: Float, expectation: Expectation) -> tuple[Float, Float, Float]:
    """R(s, d'), E[R(s, D')] and E[R(S', D'')] of every state, each (steps + 1, n).

    The last state has no step of its own: a step on the spot stands in, whose pay is not looked at.
    """
    states = {DISTANCE: np.vstack([distances, distances[-1:]])}
    with np.errstate(all="ignore"):
        rows = [
            (np.asarray(paid.total, np.float64), *expectation(reward, carry, step))
            for carry, step, paid in paid_along(reward, states)
        ]
    here, expected, beyond = zip(*rows, strict=True)
    return np.stack(here), np.stack(expected), np.stack(beyond)


def _recorded(rollouts: Sequence[Rollout]) -> tuple[Float, Float]:
    """Distances before and after all recorded steps, (transitions,), [m]."""
    before = np.concatenate([rollout.distances[:-1][rollout.running] for rollout in rollouts])
    return before, np.concatenate([rollout.distances[1:][rollout.running] for rollout in rollouts])


def _levels(count: int) -> Float:
    """The middles of `count` equal parts of [0, 1]."""
    levels: Float = (np.arange(count) + 0.5) / count
    return levels


def _leading_to(step: Steps, distance: Float) -> Steps:
    """The same step, but that it leads to `distance`."""
    return step._replace(distance=distance, delta_distance=distance - step.previous_best)


def _following(step: Steps, distance: Float) -> Steps:
    """The step after this one, leading to `distance`."""
    best = np.minimum(step.previous_best, step.distance)
    state, after = {DISTANCE: step.distance}, {DISTANCE: distance}
    return step_between(state, after, step.begin_distance, best, step.step + 1.0)


def _mean(value: Any, count: int) -> Float:
    """The mean of each env's `count` values, (n * count,) to (n,)."""
    mean: Float = np.asarray(value, np.float64).reshape(-1, count).mean(axis=1)
    return mean


def _each(size: int, count: int) -> NDArray[np.int64]:
    """The numbers of `size` envs, each `count` times."""
    return np.repeat(np.arange(size), count)


def _repeated(carry: Carry, count: int) -> Carry:
    """Each env's entry `count` times."""
    if isinstance(carry, tuple):
        return tuple(_repeated(part, count) for part in carry)
    return np.repeat(carry, count, axis=0)
