"""How many arms without dynamics one thread moves."""

import numpy as np
import pytest

import harness

pytestmark = pytest.mark.bench
NUM_ENVS = 1024


def test_1024_envs_have_half_the_speed_of_bare_kinematics(require_speed, step_through, amount):
    """Observation and reward on, episodes that end and start included, they do half of the steps of numpy alone.

    That is one matrix product per joint and nothing else: no ground contact, no limits, no reward. 0.62 to 0.70 was
    measured, 600,000 to 700,000 env steps/s.
    """
    env = harness.make_env("kinematic", num_envs=NUM_ENVS)
    env.reset(seed=0)
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (amount(100, 2), NUM_ENVS, 6)).astype(np.float32)
    chain = env.robot.chain

    def bare() -> None:
        for qpos in actions.astype(np.float64):
            sine, rest = np.sin(qpos)[..., None, None], 1.0 - np.cos(qpos)[..., None, None]
            T_world_child = np.eye(4)
            for joint, (first, second) in enumerate(zip(*chain.terms, strict=True)):
                turned = chain.T_previous_joint[joint] + sine[:, joint] * first + rest[:, joint] * second
                T_world_child = T_world_child @ turned
            assert (T_world_child @ chain.T_last_tip).shape == (NUM_ENVS, 4, 4)

    require_speed(bare, lambda: step_through(env, actions), at_least=0.5)
