"""How episodes begin and end."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from gymnasium.vector import AutoresetMode
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

import harness
from harness.record import TraceWriter, read_trace
from harness.task import ReachTask
from tests.refusals import refused

Call = Callable[..., Any]


def test_episode_begins_outside_of_epsilon(make):
    """No episode begins on its target, however large epsilon is."""
    env = make(task=ReachTask(epsilon=0.4, horizon=1))
    _, infos = env.reset(seed=0)
    for _ in range(50):
        assert (infos["distance"] > 0.4).all()
        _, infos = env.reset()


@pytest.mark.parametrize(
    ("terms", "place", "paid"),
    [
        ({}, None, 1.0 - 0.0001),
        ({}, np.array([[0.9, 0.0, -0.1]]), -1.0 - 0.0001),
        ({"target_reward": 5.0, "step_reward": -0.5}, None, 4.5),
    ],
    ids=["target", "ground", "as the task sets it"],
)
def test_an_event_ends_the_episode_and_is_paid(make, drive_to, target_of, terms, place, paid):
    """Within epsilon of the target +1 is paid on top (NOTE eq. 19), on the ground -1 (eq. 18)."""
    env = make(task=ReachTask(epsilon=0.03, **terms))
    observations, _ = env.reset(seed=2)
    is_target = place is None
    _, rewards, terminated, truncated, infos = drive_to(env, target_of(observations) if is_target else place)
    assert (terminated.tolist(), truncated.tolist()) == ([True], [False])
    assert infos["is_success"].tolist() == [infos["distance"][0] <= 0.03] == [is_target]
    assert_allclose(rewards, infos["reward_shaped"] + paid)


def test_horizon_truncates(make, stand):
    """At the horizon, and not before, the episode is truncated, which is no event and pays nothing."""
    env = make(seed=2)
    for step in range(1, 5):
        _, rewards, terminated, truncated, infos = stand(env)
        assert not terminated.any()
        assert truncated.tolist() == [step == 4]
        assert_allclose(rewards, infos["reward_shaped"] - 0.0001)


def test_target_at_the_horizon_is_no_truncation(make, drive_to, target_of):
    """An episode that reaches its target in the last step is terminated, not truncated."""
    observations, _ = make(task=ReachTask(epsilon=0.03)).reset(seed=2)
    steps = 0
    while True:
        steps += 1
        short = make(task=ReachTask(epsilon=0.03, horizon=steps), seed=2)
        *_, terminated, truncated, _ = drive_to(short, target_of(observations))
        if terminated.any():
            break
    assert steps > 2
    assert not truncated.any()


def test_same_step_starts_the_next_episode(make, wander, target_of):
    """The step that ends an episode returns the next one's start; the last observation is in the infos."""
    env = make(2, seed=0)
    wander(env, 3)
    observations, _, _, truncated, infos = wander(env, 1, seed=9)[0]
    assert truncated.all()
    assert_array_equal(infos["_final_obs"], [True, True])
    assert_allclose(infos["final_obs"][:, -1], infos["distance"], atol=1e-6)
    assert_array_equal(observations[:, 6:18], 0.0)
    assert (target_of(observations) != target_of(infos["final_obs"])).any(axis=1).all()


def test_same_step_leaves_the_other_envs_alone(make, wander):
    """When one arm starts anew the others go on as if it had not."""
    task = ReachTask(horizon=6)
    env, undisturbed = make(2, task, autoreset_mode=AutoresetMode.DISABLED), make(2, task)
    for either in (env, undisturbed):
        either.reset(seed=0)
    wander(env, 2)
    wander(undisturbed, 2)
    env.reset(options={"reset_mask": np.array([True, False])})
    for one, other in zip(wander(env, 3, seed=4), wander(undisturbed, 3, seed=4), strict=True):
        assert_array_equal(one[0][1], other[0][1])
        assert one[1][1] == other[1][1]


def test_disabled_waits_for_the_reset_mask(make, wander, target_of):
    """Without autoreset an ended episode stays ended; a reset with a mask starts those of the mask alone."""
    env = make(2, autoreset_mode=AutoresetMode.DISABLED)
    start, _ = env.reset(seed=0)
    observations, _, _, truncated, infos = wander(env, 4)[-1]
    assert truncated.all()
    assert "final_obs" not in infos
    assert_array_equal(target_of(observations), target_of(start))
    again, infos = env.reset(options={"reset_mask": np.array([False, True])})
    assert_array_equal(again[0], observations[0])
    assert (target_of(again)[1] != target_of(observations)[1]).any()
    assert infos["distance"].shape == (2,)


def test_unknown_options_are_ignored(make):
    """Without ``reset_mask`` all envs are reset, whatever else stands in the options, as in Gymnasium's own envs."""
    plain, told = make(3), make(3)
    for env in (plain, told):
        env.reset(seed=0)
    assert_array_equal(told.reset(seed=5, options={"x": 1})[0], plain.reset(seed=5)[0])
    assert_array_equal(told.episodes.episode, plain.episodes.episode)


def test_options_stay_the_callers(make):
    """A reset takes nothing out of the options."""
    options = {"reset_mask": np.array([True, False]), "x": 1}
    make(2).reset(seed=0, options=options)
    assert list(options) == ["reset_mask", "x"]


@pytest.mark.parametrize("mask", [np.ones(3, bool), np.array([1, 0]), True, "all"], ids=str)
def test_reset_mask_of_other_envs_is_a_usage_error(make, mask):
    """A mask that is not one truth value per env is refused in one line, and nothing is reset or seeded."""
    env, undisturbed = make(2), make(2)
    for either in (env, undisturbed):
        either.reset(seed=0)
    with refused(r"give bool of \(2,\)"):
        env.reset(seed=1, options={"reset_mask": mask})
    assert_array_equal(env.reset()[0], undisturbed.reset()[0])


def test_ended_episode_that_is_stepped_on_forgets_its_end(make, drive_to, target_of):
    """Without autoreset, steps after the target was reached are neither terminated nor paid for it again."""
    env = make(autoreset_mode=AutoresetMode.DISABLED, task=ReachTask(epsilon=0.03))
    observations, _ = env.reset(seed=2)
    drive_to(env, target_of(observations))
    for _ in range(10):
        _, rewards, terminated, _, infos = env.step(np.ones((1, 6), np.float32))
    assert not terminated.any()
    assert_allclose(rewards, infos["reward_shaped"] - 0.0001)


def test_an_end_is_not_told_twice_without_autoreset(tmp_path):
    """A finished env that is stepped on beside a restarted one is recorded as it is then, not as it ended."""
    away = np.zeros((2, 6), np.float32)
    away[1] = [0, -1, -1, 0, 0, 0]  # env 1 rises out of the reach of its target
    env = harness.make_env(
        num_envs=2, task="fd100-reach:epsilon=0.3,horizon=200", autoreset_mode=AutoresetMode.DISABLED
    )
    with TraceWriter(tmp_path / "trace.parquet", 6, 6) as recorder:
        env.recorder = recorder
        env.reset(seed=3)
        reached = np.zeros(2, bool)
        for action in default_rng(0).uniform(-1.0, 1.0, (200, 2, 6)).astype(np.float32):
            reached = env.step(action)[4]["is_success"]
            if reached[1]:
                break
        assert reached[1]
        env.reset(options={"reset_mask": np.array([True, False])})
        for _ in range(15):
            infos = env.step(away)[4]
    env.close()
    assert not infos["is_success"][1]
    trace = read_trace(tmp_path / "trace.parquet")
    assert not trace["reached"][trace["env"] == 1][-1]
    assert trace["reward_target"][trace["env"] == 1][-1] == 0.0
