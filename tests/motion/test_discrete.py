"""discrete: a table of minus and plus one increment, and stay."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from harness.motion.discrete import Discrete
from harness.task import build_motion
from tests.refusals import refused

INNER = ("movej", "movej-absolute", "movel", "movea", "set-joints")


@pytest.fixture(params=INNER)
def discrete(request, fd100, setting_of):
    """Of each mode."""
    motion = build_motion(f"discrete:action={request.param}", setting_of(fd100))
    assert isinstance(motion, Discrete)
    return motion


def test_choices_are_two_per_increment_and_stay(discrete):
    """One joint or axis has two."""
    assert discrete.choices == 2 * len(discrete.increments()) + 1
    assert len(discrete.increments()) in {3, 6}


def test_the_table(discrete, fd100):
    """0 stays, 2 i + 1 is minus and 2 i + 2 plus increment i."""
    qpos = np.tile(fd100.home, (discrete.choices, 1))
    actions = discrete.decode(np.arange(discrete.choices), qpos) - discrete.stay(qpos)
    assert_array_equal(actions[0], 0.0)
    assert_allclose(actions[1::2], -discrete.increments(), atol=1e-12)
    assert_allclose(actions[2::2], discrete.increments(), atol=1e-12)


def test_actions_are_within_the_box_of_the_mode(discrete, fd100):
    """At home no choice asks for more than the inner mode takes."""
    actions = discrete.decode(np.arange(discrete.choices), np.tile(fd100.home, (discrete.choices, 1)))
    assert (np.abs(actions) <= 1.0).all()


def test_no_two_choices_are_the_same_move(discrete, fd100):
    """Every choice brings the arm to a place of its own."""
    qpos = np.tile(fd100.home, (discrete.choices, 1))
    actions = discrete.decode(np.arange(discrete.choices), qpos)
    ends = discrete.advance(qpos, np.zeros_like(qpos), actions).waypoints[-1]
    gaps = np.abs(ends[:, None] - ends[None]).max(axis=-1) + np.eye(discrete.choices)
    assert gaps.min() > 1e-4


@pytest.mark.parametrize("choice", [-1, 13, 10**12])
def test_a_choice_that_is_none_is_refused(fd100, setting_of, choice):
    """Neither below 0 nor beyond the last one, and it says which there are."""
    motion = build_motion("discrete", setting_of(fd100))
    with refused("from 0 to 12"):
        motion.decode(np.array([0, choice]), np.tile(fd100.home, (2, 1)))
