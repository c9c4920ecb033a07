"""The baseline reward, Type I: pays what was gained since the start when the best is met, else takes the loss."""

import numpy as np
from hypothesis import given, strategies as st
from numpy.testing import assert_array_equal

from harness.reward import Sample
from harness_plugins.rewards.baseline import Baseline

METRES = st.floats(0.0, 3.0)


def sample(begin, best, distance):
    """A step of one env; the reward looks at these three."""
    return Sample(*(np.array([value]) for value in (begin, best, best, distance, distance - best, 1.0)))


def pay(begin, best, distance):
    """The shaped reward of the step."""
    reward = Baseline()
    _, value = reward(reward.initial_carry(np.array([begin])), sample(begin, best, distance))
    return float(value[0])


def test_value_by_hand(subtests):
    """Dd > 0: -Dd. Dd <= 0: Bd - d."""
    rows = [
        (1.0, 1.0, 0.75, 0.25),  # the first step nearer: Bd - d
        (1.0, 0.5, 0.25, 0.75),  # a new best later: all that was gained since the start, not the step
        (1.0, 0.5, 0.75, -0.25),  # farther than the best, though nearer than the start: minus the loss
        (1.0, 1.0, 1.5, -0.5),  # farther than the start
        (1.0, 0.5, 0.5, 0.5),  # Dd = 0 counts as gained: Bd - d
        (1.0, 1.0, 1.0, 0.0),  # standing still at the start
        (1.0, 0.25, 0.0, 1.0),  # on the target: all of it
    ]
    for begin, best, distance, expected in rows:
        with subtests.test(begin=begin, best=best, distance=distance, expected=expected):
            assert pay(begin, best, distance) == expected


@given(METRES, METRES, METRES)
def test_value_follows_the_published_code(begin, best, distance):
    """Any step is paid as the listing of the note pays it."""
    delta = distance - best
    assert pay(begin, best, distance) == (-delta if delta > 0.0 else begin - distance)


@given(METRES, METRES, METRES)
def test_only_a_loss_costs(begin, best, distance):
    """As the best is never worse than the start, the value is negative exactly where the best is missed."""
    best = min(begin, best)
    assert (pay(begin, best, distance) < 0.0) == (distance > best)


@given(METRES, METRES, METRES)
def test_value_is_bounded_by_the_distances(begin, best, distance):
    """No step pays more than the begin distance, nor costs more than the distance."""
    best = min(begin, best)
    assert -distance <= pay(begin, best, distance) <= begin


def test_nothing_is_carried():
    """The carry is empty, before and after."""
    reward = Baseline()
    assert reward.initial_carry(np.ones(3)) == ()
    assert reward((), sample(1.0, 1.0, 0.5))[0] == ()


def test_envs_are_paid_apart():
    """A batch of gain, loss and standing still is paid element by element."""
    begin, best, distance = np.full(3, 1.0), np.array([0.5, 0.5, 0.5]), np.array([0.25, 0.75, 0.5])
    _, values = Baseline()((), Sample(begin, best, best, distance, distance - best, np.ones(3)))
    assert_array_equal(values, [0.75, -0.25, 0.5])
