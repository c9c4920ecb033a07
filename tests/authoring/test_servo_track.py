"""What drives with limits follow in each physics step."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from harness.robot import Servo
from harness.simulator import ServoTrack

STEP = 0.005


def _track(latency=0.0, num_envs=1):
    track = ServoTrack(Servo(*[np.ones(2)] * 6, latency, True), num_envs, STEP)
    track.reset(np.zeros((num_envs, 2)), np.ones(num_envs, bool))
    return track


def _pose(*qpos):
    return np.repeat(np.array(qpos)[:, None], 2, axis=1)


def test_a_way_is_gone_at_constant_speed():
    """From the last target, which the first physics step still holds, up to the step before the new one."""
    references = _track().advance(_pose(1.0), 10 * STEP, 10)
    assert references.qpos.shape == references.qvel.shape == (10, 1, 2)
    assert_allclose(references.qpos[:, 0, 0], np.arange(10) / 10)
    assert_allclose(references.qvel, 1.0 / (10 * STEP))


def test_the_next_way_begins_at_the_last_target():
    """Exactly: rounding does not add up over ways."""
    track = _track()
    for target in (0.1, 0.3, 0.7):
        track.advance(_pose(target), 3 * STEP, 3)
    first = track.advance(_pose(0.7), 3 * STEP, 3)
    assert (first.qpos == 0.7).all()
    assert not first.qvel.any()


@given(st.lists(st.tuples(st.floats(-3, 3), st.integers(1, 7)), min_size=1, max_size=6), st.integers(0, 12))
def test_latency_shifts_all_by_whole_steps(ways, delay):
    """What comes out late is what comes out at once, after so many steps at rest."""
    prompt, late = (_played(ways, latency) for latency in (0.0, delay * STEP))
    assert (late[:delay, 1] == 0.0).all()
    assert (late[:delay, 0] == 0.0).all()
    assert_array_equal(late[delay:], prompt[: max(len(prompt) - delay, 0)])


def _played(ways, latency):
    """Positions and speeds of the first joint, (steps, 2)."""
    track = _track(latency)
    parts = [track.advance(_pose(target), steps * STEP, steps) for target, steps in ways]
    return np.concatenate([np.stack([part.qpos[:, 0, 0], part.qvel[:, 0, 0]], axis=1) for part in parts])


@pytest.mark.parametrize("latency", [0.0, 3 * STEP])
def test_reset_forgets_in_its_envs_alone(latency):
    """The env of the mask rests at its pose; the other one goes on, delayed commands included."""
    track, undisturbed = _track(latency, 2), _track(latency, 2)
    for each in (track, undisturbed):
        each.advance(_pose(1.0, 2.0), 4 * STEP, 4)
    track.reset(_pose(7.0, 8.0), np.array([True, False]))
    references, expected = (each.advance(_pose(7.0, 3.0), 4 * STEP, 4) for each in (track, undisturbed))
    assert (references.qpos[:, 0] == 7.0).all()
    assert not references.qvel[:, 0].any()
    assert_array_equal(references.qpos[:, 1], expected.qpos[:, 1])
    assert_array_equal(references.qvel[:, 1], expected.qvel[:, 1])


def test_the_callers_array_is_not_kept():
    """What the caller does to it later changes nothing."""
    track, target = _track(), _pose(1.0)
    track.advance(target, 2 * STEP, 2)
    target += 5.0
    assert track.advance(_pose(1.0), 2 * STEP, 2).qpos.max() == 1.0
