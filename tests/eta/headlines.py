"""The answers of a comparison of an arm, from its parts."""

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from harness.eta import (
    TRAINING,
    Change,
    Decomposition,
    Headline,
    Names,
    Quantity,
    Ruling,
    change_of,
    judge,
    number_sentence,
    swaps_of,
)
from harness.eta.headline import DECIDING

NAMES = Names("base", "mine")
SUCCESS = Quantity("success_rate", "", "higher", "deterministic", episodes=100)
TIME = Quantity("time_to_target", "s", "lower", "deterministic")
SPEED = Quantity("success_rate", "", "higher", TRAINING, episodes=100)
CLAIM = re.compile(r"\b([Bb]etter|[Ww]orse|helps|hurts|reaches|succeeds|faster|slower|slowly)\b")
"""What is said only where a test says it."""


def change(baseline: Sequence[float], proposed: Sequence[float], measure=SUCCESS, p: float | None = 1.0) -> Change:
    """Of seeds 0, 1, 2 ..., with this corrected p-value."""
    swaps = swaps_of(range(min(len(baseline), len(proposed))))
    return replace(change_of(measure, dict(enumerate(baseline)), dict(enumerate(proposed)), swaps), corrected=p)


def headline_of(decomposition: Decomposition, changes: Sequence[Change] = (), asked: int = 1) -> Headline:
    """As `harness.results.comparison.Comparison` gives them, with the measures of one manner."""
    deciding = [change for name in DECIDING for change in changes if change.name == name and change.seeds]
    return judge(NAMES, deciding, number_sentence(NAMES, decomposition.splits), ruling_of(deciding, asked))


def ruling_of(deciding: Sequence[Change], asked: int = 1) -> Ruling:
    """A ruling with the corrected p-values that the changes have."""
    p_values = tuple(1.0 if change.corrected is None else change.corrected for change in deciding)
    signs = tuple(
        int(np.sign(change.difference or 0.0)) * (1 if change.measure.better == "higher" else -1) for change in deciding
    )
    p = min(p_values, default=None)
    return Ruling(p, p, of_measures=p_values, signs=signs, asked=asked)
