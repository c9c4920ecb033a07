"""What is written down of an env."""

import json

import gymnasium
import numpy as np
from gymnasium.vector import SyncVectorEnv

from harness.recorder.env_facts import env_facts, plain


def test_facts_of_an_env_are_json():
    """Whatever its arguments are, and whether it is registered."""
    env = gymnasium.wrappers.TimeLimit(gymnasium.make("Pendulum-v1", g=np.float64(9.5)), 7)
    facts = env_facts(env)
    assert json.loads(json.dumps(facts)) == facts
    assert facts["class"] == "gymnasium.envs.classic_control.pendulum.PendulumEnv"
    assert facts["wrappers"][:2] == ["TimeLimit", "TimeLimit"]
    assert facts["kwargs"] == {"g": 9.5}


def test_env_without_a_spec_has_a_class():
    """And nothing else."""
    env = type("Bare", (gymnasium.Env,), {"__module__": "mine"})()
    assert env_facts(env) == {"class": "mine.Bare", "wrappers": []}


def test_batch_has_the_facts_of_its_envs():
    """Those of the first."""
    envs = [SyncVectorEnv([lambda: gymnasium.make("Pendulum-v1")]), gymnasium.make_vec("Pendulum-v1", num_envs=2)]
    assert [env_facts(batch)["id"] for batch in envs] == ["Pendulum-v1"] * 2


def test_what_json_does_not_have_is_a_name():
    """Of its class; numbers that JSON lacks are words."""
    found = plain({"a": (1, np.arange(2)), "b": object(), "c": float("inf"), 3: np.bool_(True), "d": plain})
    assert found == {"a": [1, [0, 1]], "b": "builtins.object", "c": "inf", "3": True, "d": "builtins.function"}
