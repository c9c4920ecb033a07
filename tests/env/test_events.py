"""The event terms of the baseline's own task, and the flag of a held arm."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from numpy.linalg import norm
from numpy.random import default_rng
from numpy.testing import assert_allclose

from harness.robot import forward, reach_position
from harness.task import ReachTask
from harness_plugins.tasks.unity import Arp2021, UnityReach
from tests.registered import UNITY_ARM as ARM

TARGET = np.array([[0.45, -0.45, 0.2]])


@pytest.fixture
def jump(make, recorded):
    """One environment step to `qpos`, and its trace."""

    def to(qpos, **task):
        taken = []
        env = make(1, Arp2021(decision_period=1, **task), robot=ARM)
        return taken, recorded(env, lambda env: taken.extend(env.step((qpos / ARM.upper).reshape(1, 5))))

    return to


def poses_at_the_target():
    """Several ways to touch the target, (n, 5)."""
    starts = default_rng(4).uniform(-0.9, 0.9, (60, 5)) * ARM.upper
    goals, reached = reach_position(ARM, np.repeat(TARGET, 60, axis=0), starts, tolerance=1e-3)
    return goals[reached & (np.abs(goals) <= ARM.upper).all(axis=1)]


def test_ground_ends_the_episode_and_costs_one(jump):
    """-1 exactly, beside the step's price."""
    goal, reached = reach_position(ARM, np.array([[0.3, -0.3, -0.05]]), ARM.home[None])
    assert reached.all()
    (_, paid, terminated, _, infos), trace = jump(goal)
    assert terminated.all()
    assert trace["ground"][1]
    assert trace["terminated"][1]
    assert (trace["reward_ground"][1], trace["reward_target"][1], trace["reward_step"][1]) == (-1.0, 0.0, -0.0001)
    assert paid[0] == pytest.approx(infos["reward_shaped"][0] - 1.0001, rel=1e-12)


def test_target_pays_half_and_the_upright_cosine(jump):
    """0.5 + clamp01(up of the end effector . up), at poses that point up, down and aside."""
    poses = poses_at_the_target()
    up = forward(ARM.chain, poses)[:, 2, 2]
    assert (up > 0.3).any()
    assert (up < -0.3).any()
    for pose, cosine in zip(poses, up, strict=True):
        _, trace = jump(pose)
        if not trace["ground"][1]:
            assert trace["reward_target"][1] == pytest.approx(0.5 + min(max(cosine, 0.0), 1.0), abs=1e-6)


def test_upright_cosine_is_that_of_the_original():
    """Unity's `transform.up`, computed from the prefab's own chain, dotted with its up."""
    nodes = json.loads((Path(__file__).parents[1] / "robots" / "unity_arm_nodes.json").read_text())
    poses = default_rng(0).uniform(ARM.lower, ARM.upper, (50, 5))
    expected = [0.5 + min(max(up_of_the_tip(nodes["chain"], pose)[1], 0.0), 1.0) for pose in poses]
    assert_allclose(UnityReach().target_rewards(ARM, poses), expected, rtol=0.0, atol=1e-9)
    assert len(np.unique(expected)) > 20


def up_of_the_tip(chain, qpos):
    """The end effector's y axis in Unity's world, (3,): turned outwards from its node to the root."""
    up = np.array([0.0, 1.0, 0.0])
    for node in reversed(chain):
        if "joint" in node:
            half = qpos[node["joint"] - 1] / 2.0
            up = turned([0.0, 0.0, math.sin(half), math.cos(half)], up)
        up = turned(node["quaternion_xyzw"], up)
    return up


def turned(quaternion_xyzw, vector):
    """The vector turned by the quaternion, whose length need not be 1."""
    x, y, z, w = np.array(quaternion_xyzw) / norm(quaternion_xyzw)
    axis = np.array([x, y, z])
    return vector + 2.0 * np.cross(axis, np.cross(axis, vector) + w * vector)


def test_rewards_of_events_are_parameters(jump):
    """Each is set by the task."""
    pose = poses_at_the_target()[0]
    up = max(forward(ARM.chain, pose)[2, 2], 0.0)
    _, trace = jump(pose, target_reward=2.0, upright_reward=3.0, step_reward=-0.5)
    assert trace["reward_target"][1] == pytest.approx(2.0 + 3.0 * up, abs=1e-6)
    assert trace["reward_step"][1] == -0.5


def test_held_arm_is_recorded(make, recorded):
    """An arm that is sent out of its reach on a line is held there; before that it is not."""
    action = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]], np.float32)
    env = make(2, ReachTask(action="movel", horizon=200, epsilon=0.001))
    trace = recorded(env, lambda env: [env.step(action) for _ in range(120)])
    held = trace["held"][trace["env"] == 0]
    assert held[-20:].all()
    assert not held[:10].any()
    assert not trace["held"][trace["env"] == 1].any()
    assert not trace["terminated"].any()


def test_joint_movements_are_never_held(make, wander, recorded):
    """MoveJ brakes before a joint's end; nothing that it is asked for cannot be done."""
    assert not recorded(make(2, ReachTask(horizon=50)), lambda env: wander(env, 100))["held"].any()
