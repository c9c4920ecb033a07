"""Rewards with a memory: each env gets a copy of its own, which measures the env that is stepped."""

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest

import harness
from harness.errors import UsageError
from harness.record import read_recording
from tests.recorder.conftest import ACTION, recorder, take


class Holds:
    """Counts its calls, and pays what it holds tells."""

    def __init__(self, held: Any, tell: Callable[[Any], float]) -> None:
        self.held, self.tell, self.calls = held, tell, 0

    def reset(self):
        """Count from 0."""
        self.calls = 0

    def __call__(self, observation, action, next_observation, info):
        """How often it was called, and what it holds."""
        self.calls += 1
        return 100 * self.calls + self.tell(self.held)


def _record(env, reward, path):
    take(recorder([lambda: env], None, path, rewards={"holds": reward}), [ACTION] * 3, None)
    return read_recording(path)["reward/holds"].tolist()


HELD = {
    "the env": lambda env: (env, lambda it: it.unwrapped.count),
    "the env below its wrappers": lambda env: (env.unwrapped, lambda it: it.count),
    "an array of the env": lambda env: (env.unwrapped._place, lambda it: it[0]),
    "the env in a list": lambda env: ([{"env": env}], lambda it: it[0]["env"].unwrapped.count),
    "a method of the env": lambda env: (env.unwrapped._observed, lambda it: it()[0]),
}


@pytest.mark.parametrize("hold", HELD.values(), ids=HELD)
def test_copy_measures_the_env_that_is_stepped(counting, tmp_path, hold):
    """It holds the env itself or a part of it: a copy of that would stay where the env began."""
    env = gymnasium.wrappers.TimeLimit(counting(9), 9)
    reward = Holds(*hold(env))
    assert _record(env, reward, tmp_path / "run") == [101.0, 202.0, 303.0]
    assert reward.calls == 0  # the recorder counted with a copy


def test_reward_that_the_env_holds_is_copied(counting, tmp_path):
    """The env may call it too: two who count with one object would count twice."""
    env = counting(9)
    env.reward = Holds(0, float)
    assert _record(env, env.reward, tmp_path / "run") == [100.0, 200.0, 300.0]
    assert env.reward.calls == 0


def test_reward_that_holds_another_env_is_refused(counting, tmp_path):
    """Nobody steps that one."""
    with pytest.raises(
        UsageError, match=r"reward 'holds' holds an env that is not the one that is recorded.*give a fu"
    ):
        _record(counting(), Holds(counting(), float), tmp_path / "run")
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("held", ["one", "a part"])
def test_reward_of_a_batch_that_holds_one_env_is_refused(tmp_path, held):
    """Each env needs a copy, and nobody can say whose env the copies should look at."""
    envs = gymnasium.make_vec("CartPole-v1", num_envs=2, vectorization_mode="sync")
    first = envs.envs[0]  # type: ignore[attr-defined]
    reward = Holds(first if held == "one" else first.unwrapped.np_random, float)
    with pytest.raises(UsageError, match=rf"each of the 2 envs needs a copy of it, but it holds {held}.* of the envs"):
        harness.RecordVectorRewards(envs, tmp_path / "run", trained_with="own", rewards={"holds": reward})
    envs.close()


def test_batched_reward_may_hold_the_batch(tmp_path):
    """There is one copy, for all envs."""
    envs = gymnasium.make_vec("CartPole-v1", num_envs=2, vectorization_mode="sync")

    class All(Holds):
        def __call__(self, *told):
            return np.array([env.unwrapped.state[0] for env in self.held.envs])

        def reset(self, mask):
            """An episode starts."""

    reward = All(envs, float)
    recorded = harness.RecordVectorRewards(
        envs, tmp_path / "run", trained_with="own", rewards={"all": reward}, batched=["all"]
    )
    recorded.reset(seed=0)
    places = [recorded.step(np.zeros(2, np.int64))[0][:, 0] for _ in range(3)]
    recorded.close()
    assert np.allclose(read_recording(tmp_path / "run")["reward/all"], np.ravel(places), atol=1e-6)
