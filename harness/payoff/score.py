"""What a reward pays along given states: those of a rollout, or made-up distances."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from harness.arrays import Float, read_only
from harness.errors import SimulationDiverged
from harness.payoff.rollout import Rollout, States
from harness.reward import LARGEST_PAID, Carry, Paid, Reward, Steps, pay
from harness.reward.steps import DISTANCE, step_between
from harness.reward.terms import require_one_each, require_same


def steps_along(states: States) -> Iterator[Steps]:
    """The steps of episodes that go through these states; as the env tracks them."""
    distances = states[DISTANCE]
    best = np.minimum.accumulate(distances, axis=0)
    rows = [{name: values[row] for name, values in states.items()} for row in range(len(distances))]
    for step in range(1, len(distances)):
        count = np.full(distances.shape[1], float(step))
        yield step_between(rows[step - 1], rows[step], distances[0], best[step - 1], count)


def paid_along(reward: Reward, states: States) -> Iterator[tuple[Carry, Steps, Paid]]:
    """What is remembered before each step of episodes that go through these states, the step, and what it is paid.

    Raises:
        UsageError: The reward reads what the states do not have, pays no number an arm, or its terms change.
    """
    states = {name: read_only(values) for name, values in states.items()}  # other rewards are paid by them too
    carry, names = reward.initial_carry(states[DISTANCE][0]), None
    for step in steps_along(states):
        with np.errstate(all="ignore"):  # a reward may divide by anything where it then takes another value
            remembered, paid = pay(reward, carry, step)
        require_one_each(paid, len(step.begin_distance))
        names = tuple(paid.terms) if names is None else names
        require_same(names, paid.terms)
        yield carry, step, paid
        carry = remembered


def pay_along(reward: Reward, states: States) -> Paid:
    """Shaped reward of every step and its terms, (steps, n); may hold NaN and infinities. See `paid_along`."""
    totals, terms = zip(*(paid for _, _, paid in paid_along(reward, states)), strict=True)
    return Paid(_stacked(totals), {name: _stacked([of[name] for of in terms]) for name in terms[0]})


def pay_distances(reward: Reward, distances: Float) -> Float:
    """What a reward pays for made-up distances, (steps + 1, n), [m]; as `pay_along`."""
    total: Float = pay_along(reward, {DISTANCE: distances}).total
    return total


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
        terms: What each of its terms paid, the same.
    """

    rollout: Rollout
    values: Float
    terms: Mapping[str, Float]

    @cached_property
    def paid(self) -> Float:
        """Shaped reward and event terms, (steps, n)."""
        return self.values + self.rollout.events


def score_rollout(reward: Reward, rollout: Rollout) -> Score:
    """What the reward would have paid during the rollout.

    Raises:
        SimulationDiverged: It pays something that is not finite, or so much that nothing can be counted with it.
        UsageError: It reads what no step of an arm has, or its terms are none.
    """
    paid = pay_along(reward, rollout.states)
    *terms, values = (np.where(rollout.running, of, 0.0) for of in (*paid.terms.values(), paid.total))
    for name, of in zip((*(f"the term '{name}'" for name in paid.terms), "the reward"), (*terms, values), strict=True):
        wrong = ~(np.abs(of) <= LARGEST_PAID)
        if wrong.any():
            step, episode = np.argwhere(wrong)[0]
            told = f"more than {LARGEST_PAID:g}" if np.isfinite(of[step, episode]) else "a number that is not finite"
            raise SimulationDiverged(f"{name} pays '{rollout.script}' {told} at step {step + 1}")
    return Score(rollout, values, dict(zip(paid.terms, terms, strict=True)))


def _stacked(values: Any) -> Float:
    return np.stack([np.asarray(value, np.float64) for value in values])
