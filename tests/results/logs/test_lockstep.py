from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st

from harness.log import LogFacts, in_memory
from harness.log.open_log import find_logs
from harness.results.logs.names import in_lockstep
from tests.registered import REGISTRY


def log(lengths, at, *, started=1.7e9):
    """Episodes of such lengths, which ended so many seconds after the file was begun."""
    facts = LogFacts(path=Path("monitor.csv"), format="Monitor", unit="episode", started=started)
    columns = {"length": np.asarray(lengths, float), "time": np.cumsum(lengths).astype(float)}
    return in_memory(facts, {**columns, "seconds": np.asarray(at, float), "reward/recorded": np.zeros(len(at))})


def environments(rng, count=4, episodes=20, begun=1.7e9):
    """Files of one training: each step of all of them takes some time, and so does learning every 64 steps."""
    lengths = rng.integers(5, 40, (count, episodes))
    ends = np.cumsum(lengths, axis=1)
    steps = np.cumsum(rng.uniform(1e-4, 1e-3, ends.max() + 1) + (np.arange(ends.max() + 1) % 64 == 0) * 0.3)
    return [
        log(own, steps[ended] + number * 1e-5 - number * 0.2, started=begun + number * 0.2)
        for number, (own, ended) in enumerate(zip(lengths, ends, strict=True))
    ]


def processes(rng, count=4, episodes=20):
    """Files of several trainings that were begun together, on processes of which none is as fast as another."""
    lengths = rng.integers(5, 40, (count, episodes))
    pace = 1e-3 * (1 + 0.1 * np.arange(count))
    return [log(own, np.cumsum(own) * each) for own, each in zip(lengths, pace, strict=True)]


@given(st.integers(0, 10_000))
def test_environments_of_one_training_go_together(seed):
    """Whatever their episodes are like, and though their processes were begun one after the other."""
    assert in_lockstep(environments(np.random.default_rng(seed))) is True


@given(st.integers(0, 10_000))
def test_processes_that_were_begun_together_do_not(seed):
    """Their clocks drift apart by more than a step."""
    assert in_lockstep(processes(np.random.default_rng(seed))) is False


def test_trainings_one_after_the_other_do_not():
    """A single episode of each tells it: one file was full before the other was begun."""
    assert in_lockstep([log([200], [9.0]), log([200], [9.0], started=1.7e9 + 10)]) is False


def test_few_episodes_do_not_tell():
    """Two files of two episodes each would end in this order by chance."""
    assert in_lockstep([log([10, 20], [1.0, 3.0]), log([12, 21], [1.2, 3.3])]) is None


def test_episodes_of_one_length_tell_by_their_times():
    """Where a time limit ends all of them, the environments of one training end at one time, and processes do not."""
    at, lengths = np.arange(1, 9) * 1.0, [200] * 8
    assert in_lockstep([log(lengths, at), log(lengths, at + 2e-4)]) is True
    assert in_lockstep([log(lengths, at), log(lengths, at + 0.3)]) is None
    assert in_lockstep([log(lengths, at), log(lengths, at * 1.4)]) is False


def test_times_that_are_equal_to_the_last_digit_do_not_tell():
    """No clock ticks so: somebody made them up, or its ticks are longer than a step."""
    at, lengths = np.arange(1, 9) * 1.0, [200] * 8
    assert in_lockstep([log(lengths, at), log(lengths, at)]) is None


def test_without_times_nobody_can_tell():
    """A file that lost its header does not say when it was begun."""
    assert in_lockstep([log([9] * 8, np.arange(8.0), started=None), log([9] * 8, np.arange(8.0))]) is None


@pytest.mark.parametrize("kind", ["DummyVecEnv", "one after the other"])
def test_files_of_stable_baselines3(tmp_path, kind):
    """Its own environments, stepped by its own batch, or each by itself."""
    env_util = pytest.importorskip("stable_baselines3.common.env_util")
    rng = np.random.default_rng(0)
    batches = [4] if kind == "DummyVecEnv" else [1, 1]
    for number, count in enumerate(batches):
        place = tmp_path / str(number)
        envs = env_util.make_vec_env("CartPole-v1", n_envs=count, seed=number, monitor_dir=str(place))
        envs.reset()
        for _ in range(400):
            envs.step(rng.integers(0, 2, count))
        envs.close()
    assert in_lockstep(find_logs(tmp_path, REGISTRY, "table").logs) is (kind == "DummyVecEnv")
