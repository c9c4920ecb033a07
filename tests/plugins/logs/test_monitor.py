"""Files that stable-baselines3's Monitor and VecMonitor write, and what happens to such files."""

import json
import warnings

import numpy as np
import pytest

from tests.plugins.logs.reading import Reader

pytest.importorskip("stable_baselines3", reason="needs the extra sb3")


def monitored(make, path, episodes, **keywords):
    """The library's Monitor, closed after so many episodes."""
    from stable_baselines3.common.monitor import Monitor as Wrapper

    env = Wrapper(make(), str(path), **keywords)
    for _ in range(episodes):
        env.reset()
        while not env.needs_reset:
            env.step(env.action_space.sample())
    env.close()
    return env


read = Reader("table", "monitor.csv")


def test_returns_and_lengths_are_those_that_monitor_holds_in_memory(counted, tmp_path):
    """The file of the library against its own lists."""
    env = monitored(counted, tmp_path / "monitor.csv", 6)
    log = read(tmp_path / "monitor.csv")
    assert log["reward/recorded"] == pytest.approx(env.get_episode_rewards(), abs=1e-6)
    assert log["length"].tolist() == env.get_episode_lengths()
    assert log["time"][-1] == env.get_total_steps()
    assert log.facts.unit == "episode"


def test_vec_monitor_of_several_envs_is_one_log(counted, counted_returns, tmp_path):
    """Episodes of three envs end together, in the order of the envs."""
    from stable_baselines3.common.vec_env import DummyVecEnv, VecMonitor

    envs = VecMonitor(DummyVecEnv([counted] * 3), str(tmp_path / "all"))
    envs.reset()
    for _ in range(2 + 3):
        envs.step(np.zeros((3, 1), np.float32))
    envs.close()
    log = read(tmp_path / "all.monitor.csv")
    assert log["reward/recorded"] == pytest.approx(np.repeat(counted_returns([0, 1]), 3), abs=1e-6)
    assert log["time"].tolist() == [2, 4, 6, 9, 12, 15]


def test_info_keywords_give_success_and_measures(counted, tmp_path):
    """True and False are 1 and 0; a column of text is left out, and told."""
    keys = ("is_success", "distance", "phase")
    monitored(counted, tmp_path / "monitor.csv", 4, info_keywords=keys)
    log = read(tmp_path / "monitor.csv")
    assert log["behaviour/success"].tolist() == [0, 1, 0, 1]
    assert log["behaviour/distance"].tolist() == [0.0, 0.5, 1.0, 1.5]
    assert log.measures == ("success", "distance")
    assert any("phase" in note for note in log.facts.notes)


def test_files_of_several_envs_tell_when_they_began_and_each_episode_ended(counted, tmp_path):
    """Whoever joins the envs of one training, as the library's own reader does, needs both."""
    from stable_baselines3.common.env_util import make_vec_env

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        envs = make_vec_env(counted, n_envs=3, monitor_dir=str(tmp_path))
    envs.reset()
    envs.step(np.zeros((3, 1), np.float32))
    envs.step(np.zeros((3, 1), np.float32))
    envs.close()
    logs = [read(path) for path in sorted(tmp_path.iterdir())]
    told = [json.loads(path.read_text().partition("\n")[0][1:])["t_start"] for path in sorted(tmp_path.iterdir())]
    assert [log.facts.started for log in logs] == told
    assert all(0.0 <= log["seconds"][0] < 60.0 for log in logs)


def test_a_file_that_monitor_appended_to_is_read_whole(counted, counted_returns, tmp_path):
    """`override_existing=False`, as in a job that is started again."""
    path = tmp_path / "monitor.csv"
    monitored(counted, path, 40)
    monitored(counted, path, 2, override_existing=False)
    log = read(path)
    assert log["reward/recorded"] == pytest.approx(counted_returns([*range(40), 0, 1]), abs=1e-6)
    assert any("goes back 1 times, first in line 43" in note for note in log.facts.notes)


def test_a_file_without_a_header_is_read_as_issue_2282_of_the_library_has_it(counted, counted_returns, tmp_path):
    """`override_existing=False` of a file that was not there writes rows alone; its own reader refuses it."""
    path = tmp_path / "run.monitor.csv"
    monitored(counted, path, 3, override_existing=False, info_keywords=("is_success",))
    assert not path.read_text().startswith("#")
    log = read(path)
    assert log["reward/recorded"] == pytest.approx(counted_returns([0, 1, 2]), abs=1e-6)
    assert log["length"].tolist() == [2, 3, 4]
    assert read(path, success="column 4")["behaviour/success"].tolist() == [0, 1, 0]
