"""Environment steps per second beside the reach tasks that others have, each as its authors ship it.

Both peers do 20 physics steps per env step and have no batch; ours has one, and one env beside it for comparison.
"""

import warnings
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import gymnasium
import numpy as np
import pytest
from numpy.random import default_rng

import harness

pytestmark = pytest.mark.bench
BATCH = 64


class _PlainEnums:
    """The module `mujoco`, with plain integers in place of the members of its enum ``mjtJoint``.

    Since mujoco 3.12 a number from an array is not found in a tuple of enum members. Gymnasium-Robotics 1.4.2 looks for
    it there, so its FetchReach cannot be made with a newer mujoco.
    """

    def __init__(self, mujoco: Any) -> None:
        self._mujoco = mujoco
        self.mjtJoint = type("mjtJoint", (), {name: int(value) for name, value in mujoco.mjtJoint.__members__.items()})

    def __getattr__(self, name):
        return getattr(self._mujoco, name)


def panda_reach():
    """``PandaReach-v3`` of panda-gym, on PyBullet."""
    _require("panda_gym")
    return gymnasium.make("PandaReach-v3")


def fetch_reach():
    """``FetchReach-v4`` of Gymnasium-Robotics, on MuJoCo.

    From the first call on, that library's module uses `_PlainEnums` in place of `mujoco`.
    """
    _require("gymnasium_robotics")
    module = import_module("gymnasium_robotics.utils.mujoco_utils")
    if not isinstance(module.mujoco, _PlainEnums):  # the env uses it when it is made and in every step
        module.mujoco = _PlainEnums(module.mujoco)
    return gymnasium.make("FetchReach-v4")


def _require(package):
    if find_spec(package) is None:
        pytest.skip(f"{package} is not installed: it is of the group peers")
    gymnasium.register_envs(import_module(package))


def _peer_steps(env, steps):
    """Random actions, drawn before; a new episode whenever one ends."""
    env.action_space.seed(0)
    actions = [env.action_space.sample() for _ in range(steps)]

    def run():
        for action in actions:
            _, _, terminated, truncated, _ = env.step(action)
            if terminated or truncated:
                env.reset()

    return run


def _our_actions(env, steps):
    return default_rng(0).uniform(-1.0, 1.0, (steps // env.num_envs, *env.action_space.shape)).astype(np.float32)


@pytest.mark.filterwarnings("ignore")  # the peers' own
@pytest.mark.parametrize(
    ("make_peer", "simulator", "num_envs", "times"),
    [
        pytest.param(panda_reach, "mujoco:substeps=20,threads=2", BATCH, 10.0, id="PandaReach, 64 envs on 2 threads"),
        # 8 is wanted. Bare mujoco.rollout on two cores that share one is itself 6 to 7 times as fast.
        pytest.param(fetch_reach, "mujoco:substeps=20,threads=2", BATCH, 6.0, id="FetchReach, 64 envs on 2 threads"),
        # A bare mj_step loop of 20 physics steps is itself 8 and 5 times as fast.
        pytest.param(panda_reach, "mujoco:substeps=20", 1, 5.0, id="PandaReach, one env"),
        pytest.param(fetch_reach, "mujoco:substeps=20", 1, 3.0, id="FetchReach, one env"),
    ],
)
def test_our_steps_beside_those_of_a_peer(make_peer, simulator, num_envs, times, require_speed, step_through, amount):
    """At least `times` the env steps per second of the peer."""
    steps = amount(640, BATCH)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        peer = make_peer()
        peer.reset(seed=0)
        ours = harness.make_env(simulator, num_envs=num_envs)
        ours.reset(seed=0)
        try:
            actions = _our_actions(ours, steps)
            require_speed(_peer_steps(peer, steps), lambda: step_through(ours, actions), times, rounds=5)
        finally:
            ours.close()
            peer.close()
