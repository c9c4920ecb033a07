"""How many arms without dynamics one thread moves."""

import os
import sys
from contextlib import ExitStack
from subprocess import PIPE, Popen

import numpy as np
import pytest

import harness

pytestmark = pytest.mark.bench
NUM_ENVS = 1024
ARM_STEPS_A_SECOND = 1_000_000
PROCESS = f"""
import sys, time
import numpy as np
import harness

env = harness.make_env("kinematic", num_envs={NUM_ENVS})
env.reset(seed=0)
actions = np.random.default_rng(0).uniform(-1.0, 1.0, (int(sys.argv[1]), {NUM_ENVS}, 6)).astype(np.float32)
env.step(actions[0])
print("ready", flush=True)
sys.stdin.readline()
start = time.perf_counter()
for action in actions:
    env.step(action)
print({NUM_ENVS} * len(actions) / (time.perf_counter() - start))
"""


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


def test_two_processes_move_a_million_arms_a_second(is_timed, amount):
    """Two at once, each with 1,024 arms, as two trainings on two cores; they begin at the same time.

    The one bound here that is no ratio: an absolute speed was asked for. It takes two cores that do nothing else.
    """
    command = [sys.executable, "-c", PROCESS, str(amount(1_000, 2))]
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    with ExitStack() as stack:
        both = [
            stack.enter_context(Popen(command, stdin=PIPE, stdout=PIPE, text=True, env=environment)) for _ in range(2)
        ]
        assert [process.stdout.readline() for process in both] == ["ready\n"] * 2
        for process in both:
            process.stdin.write("\n")
            process.stdin.flush()
        speeds = [float(process.stdout.readline()) for process in both]
    assert [process.returncode for process in both] == [0, 0]
    print(f"\n  arm-steps a second: {speeds[0]:,.0f} + {speeds[1]:,.0f} = {sum(speeds):,.0f}")  # noqa: T201
    if is_timed:
        assert sum(speeds) >= ARM_STEPS_A_SECOND
