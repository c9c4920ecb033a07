"""EPIC, DARD and STARC of an arm's rewards: they are asked about recorded states and actions.

A state is a row of a rollout: the fields of `harness.reward.steps.ARM` after a step, or at
the start; the begin distance, the smallest distance so far and the step count of its episode; and what the reward
remembers there. R(s, a, s') is what a step from s to s' is paid, whether the arm could do it or not:

    before           the fields of s; ``before.action`` is that of the recorded step that led to s
    action           that of a recorded step, a
    begin_distance, previous_best, previous_distance, step   of s and its episode
    delta_distance   the distance in s', less the smallest one in the episode of s
    other fields     those of s', its target among them
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness import Float, Ints
from harness.log.log import UNCOUNTABLE, is_countable
from harness.payoff.rollout import Rollout, paid_along
from harness.reward import Carry, Reward, pay
from harness.reward.reward import take
from harness.reward.steps import step_between

from ..distance import Form
from .asked import NoTransitionReward
from .canonical_forms import Ask, cover, forms_of

COMPARED = 2_000
"""So many of all recorded steps are compared, evenly spread."""
EPISODES = 50
"""They are those of so many episodes of each script: STARC asks about every state of an episode."""
ACTION = "action"
BEGIN, BEST, COUNT = "begin_distance", "previous_best", "step"


@dataclass(frozen=True, eq=False)
class Rows:
    """The states of some rollouts, one episode after the other.

    Attributes:
        columns: Their fields, (rows, ...) each; of their episodes `BEGIN`, and `BEST` until then, [m]; and `COUNT` of
            the step that follows, counted from 1. An action is that of the step before.
        lengths: Steps of the episodes.
        numbers: Which of all rows they are, rollout after rollout, step after step, episode after episode, (rows,).
    """

    columns: Mapping[str, NDArray[Any]]
    lengths: Sequence[int]
    numbers: Ints


def rows_of_rollouts(rollouts: Sequence[Rollout]) -> Rows:
    """The first `EPISODES` of each rollout, one after the other."""
    parts, lengths, numbers, first = list[dict[str, NDArray[Any]]](), list[int](), list[Ints](), 0
    for rollout in rollouts:
        distances = rollout.distances
        count, size = distances.shape
        begin = np.broadcast_to(distances[0], distances.shape)
        step = np.broadcast_to(np.arange(1.0, count + 1.0)[:, None], distances.shape)
        best = np.minimum.accumulate(distances, axis=0)
        parts.append({**rollout.states, BEGIN: begin, BEST: best, COUNT: step})
        of = rollout.running.sum(axis=0)[:EPISODES].tolist()
        lengths += of
        numbers += [first + episode + size * np.arange(length + 1) for episode, length in enumerate(of)]
        first += count * size
    rows = np.concatenate(numbers)
    columns = {
        name: np.concatenate([part[name].reshape(-1, *part[name].shape[2:]) for part in parts])[rows]
        for name in parts[0]
    }
    return Rows(columns, lengths, rows)


def ask_of(reward: Reward, rollouts: Sequence[Rollout], rows: Rows) -> Ask:
    """The reward as a function of rows, see the top of this module."""
    # with a step on the spot at the end, so that what is remembered in the last state is told too
    longer = [{name: np.concatenate([it, it[-1:]]) for name, it in of.states.items()} for of in rollouts]
    carry = take(_joined([carry for states in longer for carry, _ in paid_along(reward, states)]), rows.numbers)

    def ask(begin: Ints, act: Ints, end: Ints) -> Float:
        state = {name: rows.columns[name][begin] for name in rollouts[0].states}
        after = {name: rows.columns[name][act + 1 if name == ACTION else end] for name in state}
        asked = step_between(state, after, *(rows.columns[name][begin] for name in (BEGIN, BEST, COUNT)))
        values = np.asarray(pay(reward, take(carry, begin), asked)[1].total, np.float64)
        if not is_countable(values).all():
            raise NoTransitionReward(f"asked about another step than the one taken, it pays {UNCOUNTABLE}")
        return values

    return ask


def forms_of_rollouts(reward: Reward, rollouts: Sequence[Rollout], gamma: float) -> dict[str, Form]:
    """A reward in every canonical form, over recorded steps that are the same at every call.

    Args:
        reward: The reward.
        rollouts: One of each script.
        gamma: Discount per step.
    """
    rows = rows_of_rollouts(rollouts)
    coverage = cover(rows.lengths, np.random.default_rng(0), COMPARED)
    return forms_of(ask_of(reward, rollouts, rows), gamma, coverage)


def _joined(carries: Sequence[Carry]) -> Carry:
    """What is remembered in all rows; the parts are those of one step each, (n, ...)."""
    if isinstance(carries[0], tuple):
        return tuple(map(_joined, zip(*carries, strict=True)))
    return np.concatenate(carries)
