"""How far apart two rewards are, apart from scale, offset and potential shaping: EPIC (Gleave et al. 2021).

A state is what a `harness.reward.Sample` and the reward need before a step: distance d, smallest distance so far,
begin distance, step count and carry. The next state follows from the state and the next distance d' alone, so that a
reward is a function R(s, d') and the canonically shaped reward is

    C(s, s') = R(s, d') + gamma E[R(s', D)] - E[R(s, D)]

EPIC's last term, the mean of R over the coverage, is the same for all transitions and drops out of a correlation.
Coverage of the transitions: all recorded steps of all scripted policies, each weighing the same. Coverage of D:
`SAMPLES` quantiles of the distances after these steps. Shaping by a potential of the distance cancels exactly.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from harness.arrays import Float
from harness.audit.rollout import Rollout
from harness.audit.score import samples_of
from harness.reward import Carry, Reward, Sample

SAMPLES = 64
NOTHING = 1e-9
"""A canonical reward whose spread is a smaller share than this of the largest value paid is constant."""


@dataclass(frozen=True)
class Distance:
    """Pearson distance of two canonically shaped rewards.

    Attributes:
        value: sqrt((1 - rho) / 2), in [0, 1]: 0 the same but for scale, offset and potential shaping, 0.71
            unrelated, 1 opposite; None where exactly one of the two is nothing but an offset and potential shaping.
        transitions: How many recorded steps it rests on.
    """

    value: float | None
    transitions: int


def reward_distance(one: Reward, other: Reward, rollouts: Sequence[Rollout], gamma: float) -> Distance:
    """How differently two rewards rank what can be done in the recorded rollouts."""
    first, second = (_unit(canonical_values(reward, rollouts, gamma)) for reward in (one, other))
    if first is None and second is None:
        value: float | None = 0.0
    elif first is None or second is None:
        value = None
    else:
        value = min(1.0, float(np.linalg.norm(first - second)) / 2.0)  # of unit vectors: sqrt((1 - rho) / 2)
    return Distance(value, sum(int(rollout.running.sum()) for rollout in rollouts))


def canonical_values(reward: Reward, rollouts: Sequence[Rollout], gamma: float) -> tuple[Float, float]:
    """C of every recorded step, (transitions,), and the largest value that the reward paid for one."""
    reached = np.concatenate([rollout.distances[1:][rollout.running] for rollout in rollouts])
    ahead = np.quantile(reached, (np.arange(SAMPLES) + 0.5) / SAMPLES)
    shaped, largest = [], 0.0
    for rollout in rollouts:
        paid, expected = _paid_and_expected(reward, rollout.distances, ahead)
        shaped.append((paid + gamma * expected[1:] - expected[:-1])[rollout.running])
        largest = max(largest, float(np.abs(paid[rollout.running]).max()))
    return np.concatenate(shaped), largest


def _paid_and_expected(reward: Reward, distances: Float, ahead: Float) -> tuple[Float, Float]:
    """R(s, d') of every step, (steps, n), and E[R(s, D)] of every state, (steps + 1, n)."""
    carry, paid, expected = reward.initial_carry(distances[0]), [], []
    with np.errstate(all="ignore"):
        # The last state has no step of its own: a step on the spot stands in, whose distance is not looked at.
        for sample in samples_of(np.vstack([distances, distances[-1:]])):
            expected.append(_expected(reward, carry, sample, ahead))
            carry, value = reward(carry, sample)
            paid.append(np.asarray(value, np.float64))
    return np.stack(paid[:-1]), np.stack(expected)


def _expected(reward: Reward, carry: Carry, sample: Sample, ahead: Float) -> Float:
    """Mean over `ahead` of what the step pays if it leads there, (n,)."""
    count, size = len(ahead), len(sample.distance)
    begin, best, previous, _, _, step = (np.repeat(part, count) for part in sample)
    distance = np.tile(ahead, size)
    spread = Sample(begin, best, previous, distance, distance - best, step)
    _, value = reward(_repeated(carry, count), spread)
    mean: Float = np.asarray(value, np.float64).reshape(size, count).mean(axis=1)
    return mean


def _repeated(carry: Carry, count: int) -> Any:
    """Each env's entry `count` times."""
    if isinstance(carry, tuple):
        return tuple(_repeated(part, count) for part in carry)
    return np.repeat(carry, count, axis=0)


def _unit(canonical: tuple[Float, float]) -> Float | None:
    """The values without their mean and of length 1; None where they are constant."""
    values, largest = canonical
    centred = values - values.mean()
    length = float(np.linalg.norm(centred))
    if not length > NOTHING * largest * np.sqrt(len(values)):
        return None
    unit: Float = centred / length
    return unit
