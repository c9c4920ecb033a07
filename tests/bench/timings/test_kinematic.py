"""How many arms without dynamics one thread moves."""

import statistics
import time

import numpy as np
import pytest

import harness

pytestmark = pytest.mark.bench
NUM_ENVS, STEPS, ROUNDS = 1024, 100, 9


def test_1024_envs_do_half_a_million_steps_per_second(benchmark):
    """Observation and reward on, episodes that end and start included, 1,024 envs do at least 500,000 env steps/s."""
    env = harness.make_env("kinematic", num_envs=NUM_ENVS)
    env.reset(seed=0)
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (STEPS, NUM_ENVS, 6)).astype(np.float32)

    def steps_per_second() -> float:
        start = time.perf_counter()
        for action in actions:
            env.step(action)
        return STEPS * NUM_ENVS / (time.perf_counter() - start)

    steps_per_second()  # the first episodes all end in the same step
    speed = statistics.median(steps_per_second() for _ in range(ROUNDS))
    benchmark.extra_info.update(steps_per_second=speed)
    benchmark.pedantic(steps_per_second, rounds=1)
    print(f"\n  {speed:,.0f} env steps/s")  # noqa: T201
    assert speed >= 500_000
