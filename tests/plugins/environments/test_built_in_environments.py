"""The built-in environments: their contract, where their libraries are, and that they pay what they say."""

import importlib.util
import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box, Dict

from harness.environment import goal_rewards
from harness.registry import choose
from harness_plugins.kit import check_contract
from tests.refusals import refused
from tests.registered import REGISTRY

GIVEN = (
    "gymnasium:id=Pendulum-v1",
    "gymnasium:id=CartPole-v1",
    "inverted-double-pendulum",
    "fetch-reach",
    "meta-world:episode_steps=150",
)
NEEDS = {
    "inverted-double-pendulum": ("mujoco", "imageio"),
    "fetch-reach": ("gymnasium_robotics",),
    "meta-world": ("metaworld",),
}


def _built(given):
    missing = [name for name in NEEDS.get(given.partition(":")[0], ()) if importlib.util.find_spec(name) is None]
    if missing:
        pytest.skip(f"needs {', '.join(missing)}")
    return choose(REGISTRY, "environments", given).build(REGISTRY, "environments")


@pytest.mark.parametrize("given", GIVEN)
def test_it_keeps_the_contract(given):
    """As anybody's environment has to."""
    check_contract("environment", _built(given))


def test_any_id_is_made_with_what_is_given():
    """Numbers are numbers; rewards and measures are keys of info."""
    built = _built("gymnasium:id=Pendulum-v1,made_with=g=1.5,pays=a+b,tells=c+d,lower=d")
    env = built.make()
    assert env.unwrapped.g == 1.5  # type: ignore[attr-defined]
    assert dict(built.rewards(env)) == {"own": "own", "a": "a", "b": "b"}
    assert dict(built.behaviour(env)) == {"c": "c", "d": "d"}
    assert built.lower_is_better == {"d"}  # type: ignore[attr-defined]
    env.close()


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ("gymnasium:id=Pendulm-v1", "gymnasium.make.'Pendulm-v1'. fails"),
        ("gymnasium:id=Pendulum-v1,made_with=height", "'height' is malformed: write name=value"),
        ("gymnasium:id=Pendulum-v1,made_with=height=3", "gymnasium.make.'Pendulum-v1'. fails"),
    ],
)
def test_what_gymnasium_cannot_make_is_told(given, told):
    """In a line."""
    with refused(told):
        _built(given).make()


def test_the_double_pendulum_pays_as_both_versions_do():
    """Stepped alike, versions 4 and 5 of Gymnasium pay what the two rewards pay, the fall included."""
    built = _built("inverted-double-pendulum")
    env = built.make()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # version 4 is outdated, as it says
        older = gymnasium.make("InvertedDoublePendulum-v4")
    rewards = built.rewards(env)
    told, _ = env.reset(seed=3)
    older.reset(seed=3)
    older.unwrapped.set_state(env.unwrapped.data.qpos, env.unwrapped.data.qvel)  # type: ignore[attr-defined]
    ended = False
    while not ended:
        action = np.array([0.5], np.float32)
        after, v5, ended, _, info = env.step(action)
        _, v4, *_ = older.step(action)
        assert rewards["v4"](told, action, after, info) == pytest.approx(v4)
        assert rewards["v5"](told, action, after, info) == pytest.approx(v5)
        told = after
    assert v4 - v5 == pytest.approx(10.0)
    env.close()
    older.close()


def test_meta_world_pays_each_version_and_ends_when_told():
    """v1-scaled is v1 divided by 200; an episode has the steps that are asked for; a success stays one."""
    built = _built("meta-world:task=reach-v3,episode_steps=3")
    env = built.make()
    rewards = built.rewards(env)
    found = built.behaviour(env)["success"]
    told, _ = env.reset(seed=3)
    ended, steps = False, 0
    while not ended:
        after, own, _, ended, info = env.step(env.action_space.sample())
        paid = {name: reward(told, None, after, info) for name, reward in rewards.items()}
        assert paid["v2"] == pytest.approx(own)
        assert paid["v1-scaled"] == pytest.approx(paid["v1"] / 200)
        told, steps = after, steps + 1
    assert steps == 3
    assert [found(told, None, told, {"success": value}) for value in (0.0, 1.0, 0.0)] == [False, True, True]
    found.reset()
    assert not found(told, None, told, {"success": 0.0})
    env.close()


class _Bits(gymnasium.Env[Any, Any]):
    """Pays for every bit that is as it should be, each time of a whole batch or of one step."""

    observation_space = Dict({name: Box(0.0, 1.0, (4,)) for name in ("achieved_goal", "desired_goal")})

    def __init__(self, of_a_batch: bool = True) -> None:
        self.axis = 1 if of_a_batch else None

    def compute_reward(self, achieved, desired, info):
        return -np.abs(achieved - desired).sum(axis=self.axis)


@pytest.mark.parametrize(
    ("env", "names"),
    [
        (_Bits(), {"own"}),
        (_Bits(of_a_batch=False), set()),
        (gymnasium.make("harness/ReachGoal-v0", simulator="kinematic"), set()),
        (gymnasium.make("Pendulum-v1"), set()),
    ],
    ids=["goals", "one step's goals", "goals and info", "no goals"],
)
def test_what_an_env_pays_is_a_function_of_goals_where_it_says_so(env, names):
    """By its `compute_reward`, which needs the goals of many steps and nothing else."""
    assert goal_rewards(_built("gymnasium:id=Pendulum-v1"), env).keys() == names
