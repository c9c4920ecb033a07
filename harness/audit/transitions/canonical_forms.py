"""Three canonical forms of a reward R(s, a, s') in any environment; potential shaping is gone from each.

    EPIC   (Gleave et al. 2021)   R(s, a, s') + E[gamma R(s', A, S') - R(s, A, S')]
    DARD   (Wulfe et al. 2022)    R(s, a, s') + E[gamma R(s', A, S'') - R(s, A, S') - gamma R(S', A, S'')]
    STARC  (Skalse et al. 2024)   R(s, a, s') + gamma V(s') - V(s)

EPIC's A and S' are any action and any state that were met, independent of one another; its last term is a constant and
drops out of a correlation. In an env of which nothing is known but walks through it, no other step from s was met. So
DARD and STARC take steps that are near in time in its place: at most `NEAR` before or after, in the same episode. For
the step k of these, A is the action of step k, S' the state after it and S'' the state after step k + 1. STARC's V is
the value, with these steps for what may be done from a state:

    V(s_t) = mean over k of R(s_t, a_k, s_k+1) + gamma V(s_k+1)

It is the form that the paper calls value-adjusted levelling, with the recorded s' in place of the mean over all s' that
may follow a. Each of the three is unchanged to rounding when gamma phi(s') - phi(s) is added to R, whatever phi is.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from harness.arrays import Float
from harness.audit.transitions.asked import OfTransition
from harness.recorder.walk import Walk

NEAR = 5
"""Steps that are at most so many before or after are near in time."""


@dataclass(frozen=True, eq=False)
class Coverage:
    """Which transitions of an episode are compared, and what EPIC sets beside them.

    Attributes:
        walk: The episode.
        chosen: Numbers of the steps that are compared, counted from 0, rising.
        actions: EPIC's A, (samples,).
        states: EPIC's S', as many.
    """

    walk: Walk
    chosen: Sequence[int]
    actions: Sequence[Any]
    states: Sequence[Any]


def paid_by(pay: OfTransition, coverage: Coverage) -> Float:
    """R itself of the compared transitions, (compared,)."""
    walk = coverage.walk
    return np.array([pay(walk.states[t], walk.actions[t], walk.states[t + 1]) for t in coverage.chosen])


def epic_form(pay: OfTransition, gamma: float, coverage: Coverage) -> Float:
    """EPIC's form of the compared transitions, but for its constant, (compared,)."""
    elsewhere: dict[int, float] = {}  # by the number of the state: a state ends one step and begins the next
    for t in coverage.chosen:
        for number in (t, t + 1):
            if number not in elsewhere:
                steps = zip(coverage.actions, coverage.states, strict=True)
                state = coverage.walk.states[number]
                elsewhere[number] = float(np.mean([pay(state, action, following) for action, following in steps]))
    shaping = np.array([gamma * elsewhere[t + 1] - elsewhere[t] for t in coverage.chosen])
    form: Float = paid_by(pay, coverage) + shaping
    return form


def dard_form(pay: OfTransition, gamma: float, coverage: Coverage) -> Float:
    """DARD's form of the compared transitions, (compared,)."""
    states, actions = coverage.walk.states, coverage.walk.actions
    last = len(actions)
    shaping = []
    for t in coverage.chosen:
        terms = [
            gamma * pay(states[t + 1], actions[k], states[min(k + 2, last)])
            - pay(states[t], actions[k], states[k + 1])
            - gamma * pay(states[k + 1], actions[k], states[min(k + 2, last)])
            for k in near(t, last)
        ]
        shaping.append(np.mean(terms))
    form: Float = paid_by(pay, coverage) + np.array(shaping)
    return form


def starc_form(pay: OfTransition, gamma: float, coverage: Coverage) -> Float:
    """STARC's form of the compared transitions, (compared,); gamma is below 1."""
    value = _values(pay, gamma, coverage.walk)
    chosen = np.asarray(coverage.chosen)
    form: Float = paid_by(pay, coverage) + gamma * value[chosen + 1] - value[chosen]
    return form


def near(t: int, steps: int) -> range:
    """Numbers of the steps of an episode that are near in time to state t, at least one."""
    return range(min(max(0, t - NEAR), steps - 1), min(t + NEAR + 1, steps))


def _values(pay: OfTransition, gamma: float, walk: Walk) -> Float:
    """V of all states of an episode, (steps + 1,).

    A state depends on those near in time only: the matrix is banded, and its time grows with the episode's length.
    """
    from scipy.linalg import solve_banded

    steps = len(walk.actions)
    below, above = NEAR, NEAR + 1
    bands, paid = np.zeros((below + above + 1, steps + 1)), np.zeros(steps + 1)
    bands[above] = 1.0
    for t, state in enumerate(walk.states):
        numbers = near(t, steps)
        paid[t] = np.mean([pay(state, walk.actions[k], walk.states[k + 1]) for k in numbers])
        for k in numbers:
            bands[above + t - (k + 1), k + 1] -= gamma / len(numbers)
    value: Float = solve_banded((below, above), bands, paid)
    return value
