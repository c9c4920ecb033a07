"""How jerky the joints move."""

import numpy as np
import pytest
from numpy.random import default_rng

from harness.log import trace_of
from harness_plugins.metrics.episodes import Smoothness


def move(*episodes, truncated=True):
    """Finished episodes with these joint positions, (rows, dof) each."""
    lengths = [len(qpos) for qpos in episodes]
    rows = sum(lengths)
    ended = np.isin(np.arange(rows), np.cumsum(lengths) - 1)
    return trace_of(
        {
            "env": np.zeros(rows, np.int32),
            "episode": np.repeat(np.arange(len(episodes), dtype=np.int32), lengths),
            "reward": np.zeros(rows),
            "ground": np.zeros(rows, bool),
            "reached": np.zeros(rows, bool),
            "terminated": np.zeros(rows, bool),
            "truncated": ended & truncated,
            "qpos": np.concatenate(episodes),
        }
    )


STEPS = np.arange(6.0)[:, None]


def test_constant_speed_is_perfectly_smooth():
    """Whatever the speed of each joint."""
    assert Smoothness()(move(STEPS * [0.5, -2.0])) == 0.0


def test_constant_acceleration():
    """The second difference of a t^2 / 2 is a in every step."""
    assert Smoothness()(move(STEPS**2 / 2.0 * [3.0])) == pytest.approx(3.0)


def test_root_mean_square_over_the_steps():
    """Large jerks count more: second differences of 3 and 4 give sqrt(12.5)."""
    qpos = np.cumsum(np.cumsum([0.0, 0.0, 3.0, 4.0]))[:, None]
    assert Smoothness()(move(qpos)) == pytest.approx(np.sqrt(12.5))


def test_mean_over_the_joints():
    """Each joint by itself: one that shakes with 2 and one that is smooth make 1."""
    assert Smoothness()(move(STEPS**2 / 2.0 * [2.0, 0.0])) == pytest.approx(1.0)


def test_every_step_counts_once():
    """Episodes are put together step by step: four second differences of 1 and one of 2 give sqrt(8 / 5)."""
    long, short = STEPS**2 / 2.0, np.array([[0.0], [0.0], [2.0]])
    assert Smoothness()(move(long, short)) == pytest.approx(np.sqrt(8 / 5))


def test_jump_to_the_next_start_is_no_jerk():
    """Episodes are told apart, and so are envs."""
    assert Smoothness()(move(STEPS, STEPS + 100.0, STEPS)) == 0.0
    trace = move(np.repeat(STEPS, 2, axis=0) * 1.0)
    trace["qpos"][1::2] += 50.0
    trace["env"][1::2] = 1
    trace["truncated"][-2] = True
    assert Smoothness()(trace) == 0.0


def test_scaling_the_motion_scales_it():
    """Twice the motion is twice as jerky."""
    qpos = default_rng(0).normal(size=(9, 3))
    assert Smoothness()(move(2.0 * qpos)) == pytest.approx(2.0 * Smoothness()(move(qpos)))


@pytest.mark.parametrize("rows", [1, 2])
def test_none_without_two_steps(rows):
    """One step has no second difference; beside a longer episode it does not count."""
    assert Smoothness()(move(np.ones((rows, 2)))) is None
    assert Smoothness()(move(np.ones((rows, 1)), STEPS**2 / 2.0)) == pytest.approx(1.0)
