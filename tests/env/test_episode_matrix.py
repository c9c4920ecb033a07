"""Where the episodes of a batch stand."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from harness.env.episodes import Episodes
from harness.record import COLUMN, SCALARS
from harness.simulator import State

DOF, ACTIONS = 2, 3
ALL = np.ones(2, bool)


def state(tip, qpos=0.0, qvel=0.0):
    """Two arms whose end effectors are at x = `tip`."""
    ends = np.array([[tip, 0.0, 0.0]] * 2)
    return State(np.full((2, DOF), qpos), np.full((2, DOF), qvel), ends, np.zeros(2, bool))


@pytest.fixture
def episodes():
    """Two, that began 3 m and 4 m from their targets."""
    begun = Episodes(2, DOF, ACTIONS)
    begun.start(ALL, state(0.0), np.array([[3.0, 0.0, 0.0], [0.0, 4.0, 0.0]]))
    return begun


def test_row_is_the_traces(episodes):
    """The recorded part is as wide as a row of a trace, and every array is a view into it."""
    assert episodes.record.shape == (2, len(SCALARS) + DOF + ACTIONS)
    episodes.action[...] = 7.0
    assert_array_equal(episodes.record[:, -ACTIONS:], 7.0)
    assert_array_equal(episodes.record[:, COLUMN["env"]], [0, 1])
    assert_array_equal(episodes.record[:, COLUMN["target_y"]], [0.0, 4.0])


def test_start_is_the_begin_distance(episodes):
    """Bd, Pb and d are the same, at step 0."""
    for column in (episodes.begin_distance, episodes.previous_best, episodes.distance):
        assert_array_equal(column, [3.0, 4.0])
    assert_array_equal(episodes.step, 0.0)


def test_measure_follows_the_state(episodes):
    """Distance, offset, difference to the best, and the distance before."""
    assert_allclose(episodes.measure(state(1.0, 0.5, 0.25)), [2.0, np.sqrt(17.0)])
    assert_allclose(episodes.delta_distance, [-1.0, np.sqrt(17.0) - 4.0])
    assert_array_equal(episodes.steps.previous_distance, [3.0, 4.0])
    assert_array_equal(episodes.offset, [[2.0, 0.0, 0.0], [-1.0, 4.0, 0.0]])
    assert_array_equal(episodes.qvel_change, 0.25)
    assert_array_equal(episodes.step, 1.0)


@pytest.fixture
def examples():
    """The NOTE's examples: an end effector comes from (1, -1.5, 2) to (0.5, -1, 2), its target is at (1, 1, 2)."""
    begun = Episodes(1, DOF, ACTIONS)
    rest, nowhere = np.zeros((1, DOF)), np.zeros(1, bool)
    first, second = (State(rest, rest, np.array([tip]), nowhere) for tip in ((1.0, -1.5, 2.0), (0.5, -1.0, 2.0)))
    begun.start(np.ones(1, bool), first, np.array([[1.0, 1.0, 2.0]]))
    begun.measure(second)
    return begun


def test_example_1_of_the_note(examples):
    """The distance of (1, 1, 2) and (0.5, -1, 2); of the difference, printed with a wrong sign, as it is."""
    assert_array_equal(examples.offset, [[0.5, 2.0, 0.0]])
    assert examples.distance[0] == np.sqrt(4.25)


def test_example_2_of_the_note(examples):
    """From sqrt(6.25) to sqrt(4.25): the difference is what the note calls the reward."""
    sample = examples.steps
    assert sample.previous_distance[0] == np.sqrt(6.25)
    assert sample.previous_distance[0] - sample.distance[0] == np.sqrt(6.25) - np.sqrt(4.25)


def test_new_target_restarts_the_distances_of_its_env(episodes):
    """The other's stay; the step is counted on."""
    episodes.measure(state(1.0))
    kept = episodes.matrix[1].copy()
    episodes.set_target(np.array([True, False]), np.array([[1.0, 5.0, 0.0], [9.0, 9.0, 9.0]]))
    assert episodes.begin_distance[0] == episodes.previous_best[0] == episodes.distance[0] == 5.0
    assert episodes.steps.previous_distance.tolist() == [5.0, 4.0]
    assert episodes.delta_distance[0] == 0.0
    assert episodes.step[0] == 1.0
    assert_array_equal(episodes.matrix[1], kept)


def test_columns_of_several_arrays(episodes):
    """Where they stand in the matrix, one after the other."""
    columns = episodes.columns("qpos", "distance", "offset")
    assert_array_equal(
        episodes.matrix[:, columns],
        np.concatenate([episodes.qpos, episodes.distance[:, None], episodes.offset], axis=1),
    )
