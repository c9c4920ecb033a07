"""The step's gain relative to the distance, NOTE eq. 27-34."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

from harness.registry import build
from harness_plugins.rewards.relative import FLOOR, Relative
from tests.refusals import refused

METRES = st.floats(0.0, 1e3)
DISTANCES = st.lists(METRES, min_size=2, max_size=30)
CURRENT = Relative(denominator="current")


def test_unknown_denominator_is_refused():
    """The message says what there is."""
    with refused("denominator='smaller': Input should be 'larger' or 'current'"):
        build(Relative, {"denominator": "smaller"}, "reward 'relative'")


def test_value_by_hand(episode, subtests):
    """The gain over the larger of the two distances, or over the current one."""
    rows = [
        (1.0, 0.5, 0.5, 1.0),  # eq. 30 is 1 where a step halves the distance
        (1.0, 0.25, 0.75, 3.0),  # and above 1 beyond that
        (0.5, 1.0, -0.5, -0.5),  # eq. 33
        (0.5, 0.5, 0.0, 0.0),
        (1.0, 0.0, 1.0, 1.0 / FLOOR),  # onto the target
        (0.0, 1.0, -1.0, -1.0),  # away from it
        (0.0, 0.0, 0.0, 0.0),  # standing on it
    ]
    for before, after, larger, current in rows:
        with subtests.test(before=before, after=after, larger=larger, current=current):
            assert episode(Relative(), [2.0, before, after])[-1] == larger
            assert episode(CURRENT, [2.0, before, after])[-1] == current


def test_examples_of_the_note(episode):
    """Example 1 gives the distance of example 2, which gives the numerator alone: neither denominator pays that."""
    distance = math.dist((1, 1, 2), (0.5, -1, 2))
    assert distance == math.sqrt(4.25)
    gain = math.sqrt(6.25) - distance
    assert gain == pytest.approx(0.438447, abs=1e-6)
    assert episode(CURRENT, [math.sqrt(6.25), distance]) == pytest.approx(gain / math.sqrt(4.25))
    assert episode(Relative(), [math.sqrt(6.25), distance]) == pytest.approx(gain / math.sqrt(6.25))


@given(DISTANCES)
def test_larger_keeps_the_stated_ranges(episode, distances):
    """In [0, 1] when coming closer, eq. 31 and Table III; in [-1, 0] when moving away, eq. 34."""
    values, closer = episode(Relative(), distances), np.diff(distances) <= 0.0
    assert ((values[closer] >= 0.0) & (values[closer] <= 1.0)).all()
    assert ((values[~closer] >= -1.0) & (values[~closer] <= 0.0)).all()


@given(METRES, METRES)
def test_denominators_agree_when_moving_away(episode, before, after):
    """There the current distance is the larger one; eq. 33. Below the floor, `current` charges less."""
    before, after = sorted((before, after))
    if after >= FLOOR:
        assert episode(CURRENT, [1.0, before, after])[-1] == episode(Relative(), [1.0, before, after])[-1]
    else:
        assert -1.0 <= episode(CURRENT, [1.0, before, after])[-1] <= 0.0


def test_current_has_no_bound_of_its_own(episode):
    """The nearer to the target a step ends, the more it pays, without end: eq. 31 does not hold for eq. 30."""
    values = [episode(CURRENT, [1.0, distance])[0] for distance in (0.5, 0.1, 0.01, 0.001, 1e-6)]
    assert values == pytest.approx([1.0, 9.0, 99.0, 999.0, 999999.0])


@given(DISTANCES)
def test_current_is_finite_and_below_what_the_floor_allows(episode, distances):
    """-1 <= r <= d(t-1) / 1e-6 m, on the target too."""
    values = episode(CURRENT, distances)
    assert (values >= -1.0).all()
    assert (values <= np.array(distances[:-1]) / FLOOR).all()
