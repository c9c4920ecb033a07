"""The answers of a comparison of an arm, from its parts."""

import re
from dataclasses import replace

import numpy as np
from hypothesis import strategies as st

from harness.eta import (
    Answer,
    Names,
    Quantity,
    Ruling,
    Verdict,
    change_of,
    number_sentence,
    swaps_of,
)
from tests.results.told import SUCCESS

NAMES = Names("base", "mine")
TIME = Quantity("time_to_target", "s", "lower", "deterministic", bounds=(0.0, 10.0))
DECIDED = (Answer.HELPS, Answer.HURTS, Answer.LEARNS_FASTER, Answer.LEARNS_SLOWER, Answer.MIXED)
PAIRS = st.lists(st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0)), min_size=1, max_size=8)
"""Of shares of success under both rewards."""
CLAIM = re.compile(r"\b([Bb]etter|[Ww]orse|helps|hurts|reaches|succeeds|faster|slower|slowly)\b")
"""What is said only where a test says it."""


def change(baseline, proposed, measure=SUCCESS, p=1.0):
    """Of seeds 0, 1, 2 ..., with this corrected p-value."""
    swaps = swaps_of(range(min(len(baseline), len(proposed))))
    return replace(change_of(measure, dict(enumerate(baseline)), dict(enumerate(proposed)), swaps), corrected=p)


def headline_of(decomposition, changes=(), asked=1):
    """As `harness.results.comparison.Comparison` gives them, with the measures of one manner."""
    deciding = [it for name in (SUCCESS.name, TIME.name) for it in changes if it.name == name and it.seeds]
    return Verdict(NAMES, deciding, ruling_of(deciding, asked)).headline(number_sentence(NAMES, decomposition.splits))


def ruling_of(deciding, asked=1):
    """A ruling with the corrected p-values that the changes have; a small one passes plainly."""
    p_values = tuple(1.0 if change.corrected is None else change.corrected for change in deciding)
    signs = tuple(
        int(np.sign(change.difference or 0.0)) * (1 if change.measure.better == "higher" else -1) for change in deciding
    )
    p = min(p_values, default=None)
    beyond = tuple(it <= 0.05 and sign != 0 for it, sign in zip(p_values, signs, strict=True))
    return Ruling(p, p, p_values, signs, beyond, asked)
