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

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from harness.arrays import Float
from harness.recorder.sealed import Walk

from ..distance import DARD, EPIC, FORMS, STARC, Form, centred_unit, unit
from .asked import NoTransitionReward, OfTransition

TRANSITIONS = 500
"""So many of all recorded transitions are compared, evenly spread."""
SAMPLES = 64
"""So many actions and states stand for EPIC's A and S'."""
NEAR = 5
"""Steps that are at most so many before or after are near in time."""

Step: TypeAlias = tuple[Any, Any, Any]
"""State, action and next state, as a `Walk` has them."""
Ask: TypeAlias = Callable[[Sequence[Step]], Float]
"""R(s, a, s') of some steps, (steps,)."""


def one_by_one(pay: OfTransition) -> Ask:
    """Ask a reward of single transitions."""
    return lambda steps: np.array([pay(*step) for step in steps])


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


def draw_coverages(walks: Sequence[Walk], rng: np.random.Generator, most: int = TRANSITIONS) -> list[Coverage]:
    """The transitions that are compared, `most` of them, and EPIC's samples: actions and states, of all that were met.

    All walks have the same samples, so that EPIC's form is one function. A walk of which nothing is compared is left
    out.
    """
    ends = np.cumsum([len(walk.actions) for walk in walks])
    begins, count = [0, *ends[:-1].tolist()], int(ends[-1])
    chosen = np.unique(np.linspace(0, count - 1, min(most, count)).round().astype(int))
    actions = [action for walk in walks for action in walk.actions]
    states = [state for walk in walks for state in walk.states[1:]]
    drawn = [[values[place] for place in rng.integers(count, size=SAMPLES)] for values in (actions, states)]
    found = [
        Coverage(walk, (chosen[(begin <= chosen) & (chosen < end)] - begin).tolist(), *drawn)
        for walk, begin, end in zip(walks, begins, ends, strict=True)
    ]
    return [coverage for coverage in found if coverage.chosen]


def forms_of(ask: Ask, gamma: float, coverages: Sequence[Coverage]) -> dict[str, Form]:
    """A reward in all of `FORMS`.

    Args:
        ask: The reward.
        gamma: Discount per step; at 1 the reward has no STARC form.
        coverages: Of the walks, see `draw_coverages`.
    """
    return {form: _form(ask, form, gamma, coverages) for form in FORMS}


def _form(ask: Ask, form: str, gamma: float, coverages: Sequence[Coverage]) -> Form:
    if form == STARC and gamma == 1.0:
        return "it takes the value of a state away, which needs a discount below 1"
    try:
        with np.errstate(all="ignore"):  # what is not finite is refused
            values = np.concatenate([_FORM[form](ask, gamma, coverage) for coverage in coverages])
            largest = max(float(np.abs(paid_by(ask, coverage)).max()) for coverage in coverages)
    except NoTransitionReward as error:
        return str(error)
    # EPIC and DARD compare by correlation; STARC's standard form has length 1, and keeps its mean.
    return (unit if form == STARC else centred_unit)(values, largest)


def paid_by(ask: Ask, coverage: Coverage) -> Float:
    """R itself of the compared transitions, (compared,)."""
    walk = coverage.walk
    return ask([(walk.states[t], walk.actions[t], walk.states[t + 1]) for t in coverage.chosen])


def epic_form(ask: Ask, gamma: float, coverage: Coverage) -> Float:
    """EPIC's form of the compared transitions, but for its constant, (compared,)."""
    numbers = sorted({number for t in coverage.chosen for number in (t, t + 1)})  # one step's end is another's begin
    steps = list(zip(coverage.actions, coverage.states, strict=True))
    states = (coverage.walk.states[number] for number in numbers)
    elsewhere = dict(zip(numbers, _means(ask, ([(state, *step) for step in steps] for state in states)), strict=True))
    shaping = np.array([gamma * elsewhere[t + 1] - elsewhere[t] for t in coverage.chosen])
    form: Float = paid_by(ask, coverage) + shaping
    return form


def dard_form(ask: Ask, gamma: float, coverage: Coverage) -> Float:
    """DARD's form of the compared transitions, (compared,)."""
    states, actions = coverage.walk.states, coverage.walk.actions
    last = len(actions)
    beside = [near(t, last) for t in coverage.chosen]
    pairs = [(t, k) for t, numbers in zip(coverage.chosen, beside, strict=True) for k in numbers]
    after = ask([(states[t + 1], actions[k], states[min(k + 2, last)]) for t, k in pairs])
    here = ask([(states[t], actions[k], states[k + 1]) for t, k in pairs])
    beyond = ask([(states[k + 1], actions[k], states[min(k + 2, last)]) for t, k in pairs])
    form: Float = paid_by(ask, coverage) + _mean_of_each(gamma * after - here - gamma * beyond, map(len, beside))
    return form


def starc_form(ask: Ask, gamma: float, coverage: Coverage) -> Float:
    """STARC's form of the compared transitions, (compared,); gamma is below 1."""
    value = _values(ask, gamma, coverage.walk)
    chosen = np.asarray(coverage.chosen)
    form: Float = paid_by(ask, coverage) + gamma * value[chosen + 1] - value[chosen]
    return form


_FORM: Mapping[str, Callable[[Ask, float, Coverage], Float]] = {EPIC: epic_form, DARD: dard_form, STARC: starc_form}


def near(t: int, steps: int) -> range:
    """Numbers of the steps of an episode that are near in time to state t, at least one."""
    return range(min(max(0, t - NEAR), steps - 1), min(t + NEAR + 1, steps))


def _values(ask: Ask, gamma: float, walk: Walk) -> Float:
    """V of all states of an episode, (steps + 1,).

    A state depends on those near in time only: the matrix is banded, and its time grows with the episode's length.
    """
    from scipy.linalg import solve_banded

    steps = len(walk.actions)
    below, above = NEAR, NEAR + 1
    bands = np.zeros((below + above + 1, steps + 1))
    bands[above] = 1.0
    beside = [near(t, steps) for t in range(steps + 1)]
    for t, numbers in enumerate(beside):
        for k in numbers:
            bands[above + t - (k + 1), k + 1] -= gamma / len(numbers)
    starts = zip(walk.states, beside, strict=True)
    paid = _means(ask, ([(state, walk.actions[k], walk.states[k + 1]) for k in numbers] for state, numbers in starts))
    value: Float = solve_banded((below, above), bands, paid)
    return value


def _means(ask: Ask, groups: Iterable[Sequence[Step]]) -> Float:
    """The mean of what the steps of each group are paid, (groups,)."""
    listed = list(groups)
    return _mean_of_each(ask([step for group in listed for step in group]), map(len, listed))


def _mean_of_each(values: Float, counts: Iterable[int]) -> Float:
    """Means of so many values each, one after the other."""
    ends = np.cumsum([*counts])
    return np.array([part.mean() for part in np.split(values, ends[:-1])])
