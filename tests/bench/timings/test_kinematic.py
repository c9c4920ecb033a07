"""How many arms without dynamics one thread moves."""

import os
import statistics
import sys
from contextlib import ExitStack
from subprocess import PIPE, Popen

import numpy as np
import pytest
from numpy.random import default_rng

import harness

pytestmark = pytest.mark.bench
NUM_ENVS = 1024
SHARE = 0.75
"""Of its speed that a process keeps beside another one."""
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
start = time.process_time()
for action in actions:
    env.step(action)
print({NUM_ENVS} * len(actions) / (time.process_time() - start))
"""


def test_1024_envs_beside_bare_kinematics(require_speed, step_through, amount):
    """Observation and reward on, episodes that end and start included, they do a good part of what numpy alone does.

    That is one matrix product per joint and nothing else: no ground contact, no limits, no reward.
    """
    env = harness.make_env("kinematic", num_envs=NUM_ENVS)
    env.reset(seed=0)
    actions = default_rng(0).uniform(-1.0, 1.0, (amount(100, 2), NUM_ENVS, 6)).astype(np.float32)
    chain = env.robot.chain

    def bare():
        for qpos in actions.astype(np.float64):
            sine, rest = np.sin(qpos)[..., None, None], 1.0 - np.cos(qpos)[..., None, None]
            T_world_child = np.eye(4)
            for joint, (first, second) in enumerate(zip(*chain.terms, strict=True)):
                turned = chain.T_previous_joint[joint] + sine[:, joint] * first + rest[:, joint] * second
                T_world_child = T_world_child @ turned
            assert (T_world_child @ chain.T_last_tip).shape == (NUM_ENVS, 4, 4)

    require_speed(bare, lambda: step_through(env, actions), at_least=0.35)


def arm_steps_a_second(processes, steps):
    """Of each of so many processes at once, in its own CPU time, with 1,024 arms; they begin at the same time."""
    command = [sys.executable, "-c", PROCESS, str(steps)]
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    with ExitStack() as stack:
        started = [
            stack.enter_context(Popen(command, stdin=PIPE, stdout=PIPE, text=True, env=environment))
            for _ in range(processes)
        ]
        assert [process.stdout.readline() for process in started] == ["ready\n"] * processes
        for process in started:
            process.stdin.write("\n")
            process.stdin.flush()
        speeds = [float(process.stdout.readline()) for process in started]
    assert [process.returncode for process in started] == [0] * processes
    assert min(speeds) > 0.0
    return statistics.mean(speeds)


def test_two_processes_at_once_beside_one(require_ratio, amount):
    """As two trainings on two cores: neither waits for the other, and the memory is fast enough for both."""
    turns = [[arm_steps_a_second(count, amount(300, 2)) for count in (1, 2)] for _ in range(amount(5, 1))]
    ratio = statistics.median(two / one for one, two in turns)
    require_ratio(ratio, SHARE, f"({turns[-1][1]:,.0f} arm-steps a second of each)")
