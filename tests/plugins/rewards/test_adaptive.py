"""The gain follows the progress."""

import itertools

import numpy as np
import pytest
from hypothesis import given, strategies as st

from harness_plugins.rewards.adaptive import Adaptive
from tests.plugins.rewards.distances import GAINS, METRES

BEGIN = st.integers(1, 3072).map(lambda n: n / 1024)
DISTANCES = st.builds(lambda begin, rest: [begin, *rest], BEGIN, st.lists(METRES, min_size=1, max_size=30))


def test_value_by_hand(episode, subtests):
    """The progress of the step times the mean of the gains at its ends, k_far = 0.5 and k_near = 1.5."""
    rows = [
        ([1.0, 0.0], (0.5 + 0.75) * 0.5),  # onto the target at once: mean gain 0.5 + 0.75, progress 1/2 -> 1
        ([1.0, 1.0], 0.0),  # standing still
        ([1.0, 3.0], (0.5 + 0.375) * -0.25),  # away, progress 1/2 -> 1/4
        ([3.0, 1.0], (0.5 + 0.625) * 0.25),  # progress 1/2 -> 3/4
        ([0.0, 0.0], 0.0),  # begun on the target, and stayed
        ([0.0, 1.0], (0.5 + 0.5) * -1.0),  # and left
    ]
    for distances, expected in rows:
        with subtests.test(distances=distances):
            assert episode(Adaptive(), distances)[-1] == expected


@given(GAINS, GAINS, DISTANCES)
def test_bounds(episode, k_far, k_near, distances):
    """|r| <= (k_far + k_near) / 2."""
    assert np.abs(episode(Adaptive(k_far, k_near), distances)).max() <= (k_far + k_near) / 2.0 * (1.0 + 1e-12)


@given(GAINS, GAINS, DISTANCES)
def test_sum_of_an_episode(episode, k_far, k_near, distances):
    """It depends on where the episode ends and not on the way, and is largest on the target."""
    total = episode(Adaptive(k_far, k_near), distances).sum()
    assert total == pytest.approx(episode(Adaptive(k_far, k_near), [distances[0], distances[-1]])[0], abs=1e-12)
    assert total <= (k_far + 3.0 * k_near) / 8.0 + 1e-12


def test_largest_sum_is_reached(episode):
    """On the target it is (k_far + 3 k_near) / 8."""
    assert episode(Adaptive(1.0, 3.0), [0.7, 0.9, 0.2, 0.0]).sum() == pytest.approx(10.0 / 8.0)


@given(METRES, METRES, BEGIN)
def test_to_and_fro_pays_nothing(episode, there, back, begin):
    """A closed way is paid 0."""
    assert episode(Adaptive(), [begin, there, back, there])[1:].sum() == pytest.approx(0.0, abs=1e-14)


def test_a_step_pays_more_the_nearer_it_is_made(episode):
    """Steps of one length towards the target are paid ever more, steps away from it charged ever less."""
    towards = episode(Adaptive(), np.linspace(1.0, 0.0, 11))
    assert all(later > earlier > 0.0 for earlier, later in itertools.pairwise(towards))
    away = episode(Adaptive(), np.linspace(1.0, 2.0, 11))
    assert all(0.0 > later > earlier for earlier, later in itertools.pairwise(away))


@given(DISTANCES)
def test_gain_lies_between_its_ends(episode, distances):
    """A step is paid between k_far and k_near times what it is paid with a gain of 1, the plain progress."""
    plain, adapted = episode(Adaptive(1.0, 1.0), distances), episode(Adaptive(0.5, 1.5), distances)
    assert (np.abs(adapted) >= 0.5 * np.abs(plain)).all()
    assert (np.abs(adapted) <= 1.5 * np.abs(plain)).all()
    assert (np.sign(adapted) == np.sign(plain)).all()
