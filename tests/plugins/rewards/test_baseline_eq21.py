"""The baseline as printed, NOTE eq. 21."""

import math

import numpy as np
from hypothesis import given, strategies as st
from numpy.testing import assert_array_equal

from harness_plugins.rewards.baseline import Baseline
from harness_plugins.rewards.baseline_eq21 import BaselineEq21
from tests.plugins.rewards.distances import DISTANCES, METRES


def test_value_by_hand(episode, subtests):
    """Dd < 0: -Dd. Dd >= 0: Bd - Pb - Dd."""
    rows = [
        ([1.0, 0.75], 0.25),  # the first step nearer: the step
        ([1.0, 0.5, 0.25], 0.25),  # a new best later: the step again, not all that was gained
        ([1.0, 0.5, 0.75], 0.25),  # turned back, nearer than the start: paid Bd - d
        ([1.0, 0.5, 0.5], 0.5),  # standing still: paid Bd - d
        ([1.0, 1.5], -0.5),  # farther than the start
        ([1.0, 1.0], 0.0),  # standing still at the start
        ([1.0, 0.25, 0.0], 0.25),  # onto the target: the step
        ([1.0, 0.0, 0.0], 1.0),  # standing on it
    ]
    for distances, expected in rows:
        with subtests.test(distances=distances):
            assert episode(BaselineEq21(), distances)[-1] == expected


def test_example_2_of_the_note(episode):
    """From sqrt(6.25) to sqrt(4.25) is paid their difference."""
    assert episode(BaselineEq21(), [math.sqrt(6.25), math.sqrt(4.25)]) == [math.sqrt(6.25) - math.sqrt(4.25)]


def test_contradiction_with_the_code(episode):
    """The same two steps, to half-way and half of that back: the code charges the way back, the print pays it."""
    there_and_back = [1.0, 0.5, 0.75]
    assert episode(Baseline(), there_and_back).tolist() == [0.5, -0.25]
    assert episode(BaselineEq21(), there_and_back).tolist() == [0.5, 0.25]


@given(DISTANCES)
def test_agreement_with_the_code(episode, distances):
    """The two pay the same where Dd = 0, and on a first step towards the target."""
    best = np.minimum.accumulate(distances)[:-1]
    delta = np.array(distances[1:]) - best
    agree = (delta == 0.0) | ((delta < 0.0) & (best == distances[0]))
    printed, run = episode(BaselineEq21(), distances), episode(Baseline(), distances)
    assert_array_equal(printed[agree], run[agree])


@given(METRES, st.integers(1, 20))
def test_waiting_pays_again_and_again(episode, distance, steps):
    """Standing still is paid Bd - d at every step."""
    assert episode(BaselineEq21(), [3.0, distance] + steps * [distance])[1:].tolist() == steps * [3.0 - distance]


@given(DISTANCES)
def test_bounds(episode, distances):
    """-d(t) <= r <= Bd."""
    values = episode(BaselineEq21(), distances)
    assert (values <= distances[0]).all()
    assert (values >= -np.array(distances[1:])).all()
