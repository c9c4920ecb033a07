"""The answers of a comparison of an arm, from its parts."""

from collections.abc import Sequence

import numpy as np

from harness.eta.behaviour_change import Change
from harness.eta.headline import DECIDING, Headline
from harness.eta.judge import judge
from harness.eta.number import number_sentence
from harness.eta.splits import Decomposition, Names
from harness.eta.verdict.ruling import Ruling


def headline_of(names: Names, decomposition: Decomposition, changes: Sequence[Change] = (), asked: int = 1) -> Headline:
    """As `harness.results.comparison.Comparison` gives them, with the measures of one manner."""
    deciding = [change for name in DECIDING for change in changes if change.name == name and change.seeds]
    return judge(names, deciding, number_sentence(names, decomposition.splits), ruling_of(deciding, asked))


def ruling_of(deciding: Sequence[Change], asked: int = 1) -> Ruling:
    """A ruling with the corrected p-values that the changes have."""
    p_values = tuple(1.0 if change.corrected is None else change.corrected for change in deciding)
    signs = tuple(
        int(np.sign(change.difference or 0.0)) * (1 if change.measure.better == "higher" else -1) for change in deciding
    )
    p = min(p_values, default=None)
    return Ruling(p, p, of_measures=p_values, signs=signs, asked=asked)
