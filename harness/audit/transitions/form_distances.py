"""How far apart two rewards are in each canonical form, in the transitions of some walks."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from harness.arrays import Float
from harness.audit.transitions.asked import NoTransitionReward
from harness.audit.transitions.canonical_forms import Ask, Coverage, dard_form, epic_form, paid_by, starc_form
from harness.audit.unit_vectors import centred_unit, distance_between, unit
from harness.recorder.walk import Walk

TRANSITIONS = 500
"""So many of all recorded transitions are compared, evenly spread."""
SAMPLES = 64
"""So many actions and states stand for EPIC's A and S'."""

EPIC, DARD, STARC = FORMS = ("EPIC", "DARD", "STARC")
_FORM: Mapping[str, Callable[[Ask, float, Coverage], Float]] = {EPIC: epic_form, DARD: dard_form, STARC: starc_form}


@dataclass(frozen=True, eq=False)
class FormVector:
    """A reward in one canonical form.

    Attributes:
        unit: Over the compared transitions, of length 1; None where the form is constant, of STARC where it is 0.
    """

    unit: Float | None


def draw_coverages(walks: Sequence[Walk], rng: np.random.Generator, most: int = TRANSITIONS) -> list[Coverage]:
    """The transitions that are compared, `most` of them, and EPIC's samples: actions and states, of all that were met.

    All walks have the same samples, so that EPIC's form is one function.
    """
    ends = np.cumsum([len(walk.actions) for walk in walks])
    begins, count = [0, *ends[:-1].tolist()], int(ends[-1])
    chosen = np.unique(np.linspace(0, count - 1, min(most, count)).round().astype(int))
    actions = [action for walk in walks for action in walk.actions]
    states = [state for walk in walks for state in walk.states[1:]]
    drawn = [[values[place] for place in rng.integers(count, size=SAMPLES)] for values in (actions, states)]
    return [
        Coverage(walk, (chosen[(begin <= chosen) & (chosen < end)] - begin).tolist(), *drawn)
        for walk, begin, end in zip(walks, begins, ends, strict=True)
    ]


def form_vector(ask: Ask, form: str, gamma: float, coverages: Sequence[Coverage]) -> FormVector | str:
    """A reward in one of `FORMS`; why there is none."""
    chosen = [coverage for coverage in coverages if coverage.chosen]
    try:
        with np.errstate(all="ignore"):  # what is not finite is refused
            values = np.concatenate([_FORM[form](ask, gamma, coverage) for coverage in chosen])
            largest = max(float(np.abs(paid_by(ask, coverage)).max()) for coverage in chosen)
    except NoTransitionReward as error:
        return str(error)
    # EPIC and DARD compare by correlation; STARC's standard form has length 1, and keeps its mean.
    return FormVector((unit if form == STARC else centred_unit)(values, largest))


def form_distance(one: FormVector, other: FormVector) -> float | None:
    """In [0, 1]; None where one of the two is nothing but offset and potential shaping."""
    return distance_between(one.unit, other.unit)
