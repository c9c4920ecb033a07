"""stable-baselines3's view of the vector env."""

from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from stable_baselines3.common.vec_env import VecEnv

import harness
from harness.algorithm import Progress
from harness.env.vector_env import ReachVectorEnv
from harness.robot import reach_position
from harness.task import ReachTask
from harness_plugins.kit import IdealSimulator
from harness_plugins.kit.trainings import NegativeDistance
from harness_plugins.sb3 import ProgressCallback, VecEnvAdapter
from harness_plugins.tasks.unity import Arp2021
from tests.registered import FD100 as ROBOT, UNITY_ARM as ARM

ARM_HOME = (ARM.home / ARM.upper).astype(np.float32)
"""The action that leaves the arm where it starts."""


def adapt(num_envs=3, **task):
    """The adapter of an env without an engine, seeded."""
    env = ReachVectorEnv(IdealSimulator(), ROBOT, ReachTask(**task), NegativeDistance(), num_envs)
    env.reset(seed=2)
    return VecEnvAdapter(env)


def stand(adapter):
    """A step without motion."""
    return adapter.step(np.zeros((adapter.num_envs, 6), np.float32))


def drive_to_target(adapter, observations):
    """Steps towards the targets, until one is reached; the last step."""
    goal, _ = reach_position(ROBOT, observations[:, 18:21], adapter.env.simulation.read().qpos)
    while True:
        way = goal - adapter.env.simulation.read().qpos
        taken = adapter.step((way / (0.1 * 0.8 * ROBOT.max_speed)).astype(np.float32))
        if taken[2].any():
            return taken


def test_it_is_a_vec_env_of_the_same_spaces():
    """The library sees the spaces of one env, and how many there are."""
    adapter = adapt()
    assert isinstance(adapter, VecEnv)
    assert adapter.num_envs == 3
    assert adapter.observation_space == adapter.env.single_observation_space
    assert adapter.action_space == adapter.env.single_action_space


def test_reset_does_not_seed():
    """A reset goes on with the env's own streams: it gives what a reset of the env gives."""
    adapter, twin = adapt(), adapt().env
    assert_array_equal(adapter.reset(), twin.reset()[0])


def test_steps_are_those_of_the_env():
    """Observations, rewards and ends are passed on, the rewards in the library's float32."""
    adapter, twin = adapt(horizon=3), adapt(horizon=3).env
    adapter.reset()
    twin.reset()
    for _ in range(7):
        observations, rewards, dones, _ = stand(adapter)
        expected = twin.step(np.zeros((3, 6), np.float32))
        assert_array_equal(observations, expected[0])
        assert_array_equal(rewards, expected[1].astype(np.float32))
        assert_array_equal(dones, expected[2] | expected[3])


def test_terminal_observation_is_the_last_of_the_episode():
    """The step that ends an episode tells its last observation, not the next one's first."""
    adapter = adapt(horizon=2)
    adapter.reset()
    before, *_ = stand(adapter)
    observations, _, dones, infos = stand(adapter)
    assert dones.all()
    for env in range(3):
        assert_array_equal(infos[env]["terminal_observation"][18:21], before[env, 18:21])
        assert (infos[env]["terminal_observation"][18:21] != observations[env, 18:21]).any()


def test_horizon_is_told_as_a_truncation():
    """At the horizon `TimeLimit.truncated` is True: the library bootstraps from the last observation."""
    adapter = adapt(horizon=1)
    adapter.reset()
    infos = stand(adapter)[3]
    assert [info["TimeLimit.truncated"] for info in infos] == [True] * 3
    assert [info["is_success"] for info in infos] == [False] * 3


def test_reached_target_is_no_truncation():
    """At the target `TimeLimit.truncated` is False, and the episode is a success."""
    adapter = adapt(num_envs=1)
    _, _, dones, infos = drive_to_target(adapter, adapter.reset())
    assert dones.tolist() == [True]
    assert infos[0]["TimeLimit.truncated"] is False
    assert infos[0]["is_success"] is True


def test_envs_that_go_on_tell_nothing():
    """Where no episode ended the info is empty, each a dict of its own."""
    adapter = adapt()
    adapter.reset()
    infos = stand(adapter)[3]
    assert infos == [{}, {}, {}]
    assert len({id(info) for info in infos}) == 3


def test_infos_are_kept_by_the_library():
    """The last observation that is told stays as it was when the env goes on."""
    adapter = adapt(horizon=1)
    adapter.reset()
    told = stand(adapter)[3][0]["terminal_observation"]
    before = told.copy()
    stand(adapter)
    assert_array_equal(told, before)


def test_closing_leaves_the_env_open():
    """The env belongs to whoever made it: it can be stepped after the library has closed its view."""
    adapter = adapt()
    adapter.reset()
    adapter.close()
    adapter.env.step(np.zeros((3, 6), np.float32))
    assert not adapter.env.closed


def test_attributes_are_those_of_the_batch():
    """An attribute is told once for each env that is asked, and cannot be set."""
    adapter = adapt()
    assert adapter.get_attr("num_envs") == [3, 3, 3]
    assert adapter.get_attr("num_envs", indices=[0]) == [3]
    with pytest.raises(AttributeError, match="num_envs"):
        adapter.set_attr("num_envs", 4)


def test_methods_are_those_of_the_batch():
    """A method's result is told once for each env that is asked."""
    assert adapt().env_method("close_extras", indices=[0, 2]) == [None, None]


def test_no_env_is_wrapped():
    """The envs of a batch have no wrappers."""
    assert adapt().env_is_wrapped(object) == [False] * 3


class Told(Progress):
    """Keeps the steps that it is told."""

    def __init__(self) -> None:
        self.steps: list[int] = []

    def __call__(self, steps):
        """Kept."""
        self.steps.append(steps)


def watch(env, progress):
    """The callback of a training that has no model yet."""
    callback = ProgressCallback(env, progress, 1000, policy_of=lambda model: None, decisions_per_update=1)
    callback.model = SimpleNamespace(logger=SimpleNamespace(name_to_value={}))
    callback.locals = {"rewards": np.zeros(env.num_envs), "dones": np.zeros(env.num_envs, bool)}
    return callback


def test_progress_is_told_now_and_then_and_at_the_end():
    """Every hundred environment steps the number is passed on, and once more when training ends."""
    told, adapter = Told(), adapt()
    adapter.env.environment_steps = 7  # taken before the training
    callback = watch(adapter.env, told)
    for _ in range(83):
        stand(adapter)
        assert callback._on_step()
    callback._on_training_end()
    assert told.steps == [102, 204, 249]


def test_progress_counts_environment_steps():
    """A decision of five steps counts as five, and one that the horizon cuts as what it took."""
    told = Told()
    env = ReachVectorEnv(IdealSimulator(), ARM, Arp2021(horizon=7), NegativeDistance(), 2)
    env.reset(seed=0)
    callback = watch(env, told)
    for _ in range(2):
        env.step(np.tile(ARM_HOME, (2, 1)))
        callback._on_training_end()
    assert told.steps == [10, 14]


def test_a_training_leaves_nothing_among_temporary_files(tmp_path, monkeypatch):
    """The library's own logger would make a folder there."""
    from harness_plugins.algorithms.ppo import Ppo

    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    env = harness.make_env("kinematic", num_envs=8)
    env.reset(seed=0)
    Ppo(rollout=8, batch_size=8, net_arch=(8,)).train(env, 16, 0, Progress())
    assert not list(tmp_path.glob("SB3-*"))
