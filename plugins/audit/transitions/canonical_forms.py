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

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from harness import Float, Ints
from harness.recorder.sealed import Walk

from ..distance import DARD, EPIC, STARC, Form, centred_unit, unit
from .asked import NoTransitionReward, OfTransition

TRANSITIONS = 500
"""So many of all recorded transitions are compared, evenly spread."""
SAMPLES = 64
"""So many actions and states stand for EPIC's A and S'."""
NEAR = 5
"""Steps that are at most so many before or after are near in time."""

Ask: TypeAlias = Callable[[Ints, Ints, Ints], Float]
"""R(s, a, s') of some steps, (steps,), by rows of a `Coverage`: that of s, of the state that a was taken in, of s'."""


def one_by_one(pay: OfTransition, walks: Sequence[Walk]) -> Ask:
    """Ask a reward of single transitions about the states and actions of walks."""
    states = [state for walk in walks for state in walk.states]
    actions = [action for walk in walks for action in (*walk.actions, None)]  # no step leaves a last state
    return lambda *steps: np.array(
        [pay(states[s], actions[a], states[after]) for s, a, after in zip(*steps, strict=True)]
    )


@dataclass(frozen=True, eq=False)
class Coverage:
    """Which transitions are compared, and what EPIC sets beside them. A state is a row, one episode after the other.

    Attributes:
        begin: Of each row, the first one of its episode, (rows,).
        last: Likewise the last one.
        steps: The rows that a step leaves, rising.
        chosen: The rows from which the steps that are compared lead to the next row, rising.
        actions: EPIC's A: the rows from which they were taken, (samples,).
        states: EPIC's S', as many.
    """

    begin: Ints
    last: Ints
    steps: Ints
    chosen: Ints
    actions: Ints
    states: Ints

    def near(self, rows: Ints) -> tuple[Ints, Ints, Ints]:
        """The steps that are near in time to rows, at least one of each, row after row.

        Returns:
            Which of the rows, from 0, and the row that the step leaves, (pairs,) both; how many there are of each row.
        """
        low = np.minimum(np.maximum(self.begin[rows], rows - NEAR), self.last[rows] - 1)
        counts = np.minimum(rows + NEAR + 1, self.last[rows]) - low
        beside = np.repeat(np.arange(len(rows)), counts)
        return beside, np.arange(len(beside)) + np.repeat(low - np.cumsum(counts) + counts, counts), counts


def cover(lengths: Sequence[int], rng: np.random.Generator, most: int = TRANSITIONS) -> Coverage:
    """The transitions that are compared, `most` of them, and EPIC's samples: actions and states, of all that were met.

    Args:
        lengths: Steps of the episodes, each at least one.
        rng: Draws the samples.
        most: See above.
    """
    rows = np.asarray(lengths) + 1
    last = np.repeat(np.cumsum(rows) - 1, rows)
    steps = np.flatnonzero(np.arange(len(last)) < last)
    chosen = np.unique(np.linspace(0, len(steps) - 1, min(most, len(steps))).round().astype(int))
    actions, states = (steps[rng.integers(len(steps), size=SAMPLES)] for _ in range(2))
    return Coverage(last + 1 - np.repeat(rows, rows), last, steps, steps[chosen], actions, states + 1)


def forms_of(ask: Ask, gamma: float, coverage: Coverage) -> dict[str, Form]:
    """A reward in all of `FORMS`.

    Args:
        ask: The reward.
        gamma: Discount per step; at 1 the reward has no STARC form.
        coverage: Of the walks, see `cover`.
    """
    forms: dict[str, Form] = {}
    for form, values_of in _FORM.items():
        try:
            with np.errstate(all="ignore"):  # what is not finite is refused
                values, largest = values_of(ask, gamma, coverage), float(np.abs(paid_by(ask, coverage)).max())
        except NoTransitionReward as error:
            forms[form] = str(error)
        else:  # EPIC and DARD compare by correlation; STARC's standard form has length 1, and keeps its mean
            forms[form] = (unit if form == STARC else centred_unit)(values, largest)
    return forms


def paid_by(ask: Ask, coverage: Coverage) -> Float:
    """R itself of the compared transitions, (compared,)."""
    return ask(coverage.chosen, coverage.chosen, coverage.chosen + 1)


def epic_form(ask: Ask, gamma: float, coverage: Coverage) -> Float:
    """EPIC's form of the compared transitions, but for its constant, (compared,)."""
    ends = np.stack([coverage.chosen, coverage.chosen + 1])
    rows, place = np.unique(ends, return_inverse=True)  # one step's end is another's begin
    count = len(coverage.actions)
    elsewhere = ask(np.repeat(rows, count), *(np.tile(it, len(rows)) for it in (coverage.actions, coverage.states)))
    before, after = elsewhere.reshape(-1, count).mean(axis=1)[place.reshape(ends.shape)]
    form: Float = paid_by(ask, coverage) + gamma * after - before
    return form


def dard_form(ask: Ask, gamma: float, coverage: Coverage) -> Float:
    """DARD's form of the compared transitions, (compared,)."""
    beside, k, counts = coverage.near(coverage.chosen)
    t, end = coverage.chosen[beside], np.minimum(k + 2, coverage.last[k])
    rest = gamma * ask(t + 1, k, end) - ask(t, k, k + 1) - gamma * ask(k + 1, k, end)
    form: Float = paid_by(ask, coverage) + np.bincount(beside, rest) / counts
    return form


def starc_form(ask: Ask, gamma: float, coverage: Coverage) -> Float:
    """STARC's form of the compared transitions, (compared,); gamma is below 1.

    The value of a state depends on those near in time only: the matrix is banded, and its time grows with the steps.
    """
    from scipy.linalg import solve_banded

    if gamma == 1.0:
        raise NoTransitionReward("it takes the value of a state away, which needs a discount below 1")
    rows, below, above = np.arange(len(coverage.begin)), NEAR, NEAR + 1
    t, k, counts = coverage.near(rows)
    bands = np.zeros((below + above + 1, len(rows)))
    bands[above] = 1.0
    bands[above + t - (k + 1), k + 1] -= gamma / counts[t]
    value = solve_banded((below, above), bands, np.bincount(t, ask(t, k, k + 1)) / counts)
    form: Float = paid_by(ask, coverage) + gamma * value[coverage.chosen + 1] - value[coverage.chosen]
    return form


_FORM: Mapping[str, Callable[[Ask, float, Coverage], Float]] = {EPIC: epic_form, DARD: dard_form, STARC: starc_form}
