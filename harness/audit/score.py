"""What a reward pays for given distances."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from harness.arrays import Float, read_only
from harness.audit.rollout import Rollout
from harness.errors import SimulationDiverged
from harness.reward import LARGEST_PAID, Reward, Sample


def samples_of(distances: Float) -> Iterator[Sample]:
    """The samples of episodes with these distances, (steps + 1, n), [m]; as the env tracks them."""
    best = np.minimum.accumulate(distances, axis=0)
    for step in range(1, len(distances)):
        before, distance = best[step - 1], distances[step]
        count = np.full(distances.shape[1], float(step))
        yield Sample(distances[0], before, distances[step - 1], distance, distance - before, count)


def pay_distances(reward: Reward, distances: Float) -> Float:
    """Shaped reward of every step, (steps, n), for distances (steps + 1, n), [m]; may hold NaN and infinities."""
    distances = read_only(distances)  # other rewards are paid by them too
    carry, values = reward.initial_carry(distances[0]), []
    with np.errstate(all="ignore"):  # a reward may divide by anything where it then takes another value
        for sample in samples_of(distances):
            carry, value = reward(carry, sample)
            values.append(np.asarray(value, np.float64))
    return np.stack(values)


def discounted_sum(values: Float, gamma: float) -> Float:
    """Sum over steps of gamma^t values(t), t from 0; (steps, n) to (n,)."""
    total: Float = gamma ** np.arange(len(values)) @ values
    return total


@dataclass(frozen=True, eq=False)
class Score:
    """A rollout as one reward pays it.

    Attributes:
        rollout: What was done.
        values: Shaped reward, (steps, n); 0 after an episode's end.
    """

    rollout: Rollout
    values: Float

    @cached_property
    def paid(self) -> Float:
        """Shaped reward and event terms, (steps, n)."""
        return self.values + self.rollout.events


def score_rollout(reward: Reward, rollout: Rollout) -> Score:
    """What the reward would have paid during the rollout.

    Raises:
        SimulationDiverged: It pays something that is not finite, or so much that nothing can be counted with it.
    """
    values = np.where(rollout.running, pay_distances(reward, rollout.distances), 0.0)
    wrong = ~(np.abs(values) <= LARGEST_PAID)
    if wrong.any():
        step, episode = np.argwhere(wrong)[0]
        told = f"more than {LARGEST_PAID:g}" if np.isfinite(values[step, episode]) else "a number that is not finite"
        raise SimulationDiverged(f"the reward pays '{rollout.script}' {told} at step {step + 1}")
    return Score(rollout, values)
