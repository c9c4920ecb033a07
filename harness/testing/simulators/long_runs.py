"""What shows only after a long time: memory that is never given back, and numbers that drift. Run on demand."""

import ctypes
import gc
import sys

import numpy as np
import psutil

from harness.reward import Array, Carry, Reward
from harness.robot import Robot
from harness.simulator import Simulator
from harness.testing.rewards.samples import pay, random_samples
from harness.testing.simulators.simulations import (
    NUM_ENVS,
    PERIOD,
    drive_out_and_back,
    opened,
    ramps,
    same,
    start_at_home,
)
from harness.testing.violations import check, require

STEPS = 10_000
WARM_UP = 0.2
"""The share of the steps in which a plugin may fill its caches."""
MOST_PER_STEP = 1_000.0
"""Bytes that a process may grow by with every step; what is kept of a step is more."""
MIB = 2**20


@check("sim-long-run")
def a_long_simulation_neither_drifts_nor_leaks(simulator: Simulator, robot: Robot) -> None:
    """After 10,000 periods an episode is the same as at the beginning, bit for bit, and the process has not grown."""
    with opened(simulator, robot) as simulation:
        first = drive_out_and_back(simulation, robot)
        targets = ramps(robot, NUM_ENVS)
        warm_up = int(WARM_UP * STEPS)
        before = 0
        for step in range(STEPS):
            if step % len(targets) == 0:
                start_at_home(simulation, robot)
            simulation.drive(targets[step % len(targets)], PERIOD)
            if step == warm_up:
                before = _resident()
        _require_no_growth(before, STEPS - warm_up, "control periods")
        last = drive_out_and_back(simulation, robot)
    drift = max(np.abs(old.qpos - new.qpos).max() for old, new in zip(first, last, strict=True))
    told = f"after {STEPS:,} periods the same episode goes another way, by up to {drift:.2g} [rad or m] of a joint"
    require(same(first, last), told)


@check("reward-long-run")
def a_long_episode_is_paid_without_growing(reward: Reward) -> None:
    """Over 10,000 steps the values are finite, the carry is as large as in the beginning, and so is the process."""
    samples = random_samples(0, steps=100)
    carry = reward.initial_carry(samples[0].begin_distance)
    warm_up = int(WARM_UP * STEPS)
    size, before = 0, 0
    for step in range(STEPS):
        carry, value = pay(reward, carry, samples[step % len(samples)])
        require(np.isfinite(value).all(), f"step {step + 1:,} is paid {value}")
        if step == warm_up:
            size, before = _bytes_of(carry), _resident()
    grown = _bytes_of(carry)
    require(grown <= size, f"the carry has {size} bytes after {warm_up:,} steps, {grown} after {STEPS:,}: it grows")
    _require_no_growth(before, STEPS - warm_up, "steps")


def _require_no_growth(before: int, steps: int, noun: str) -> None:
    grown = _resident() - before
    require(
        grown <= MOST_PER_STEP * steps + MIB,
        f"the process grew by {grown / MIB:.1f} MiB in {steps:,} {noun}, {grown / steps:,.0f} bytes each: "
        "something is kept of every one",
    )


def _resident() -> int:
    """Bytes of this process in memory, after what nobody needs is given back.

    glibc keeps freed memory, where what leaks would find room unseen: it is asked to give it back too.
    """
    gc.collect()
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None) if sys.platform == "linux" else None
    if trim is not None:
        trim(0)
    return int(psutil.Process().memory_info().rss)


def _bytes_of(carry: Carry) -> int:
    if isinstance(carry, tuple):
        return sum(map(_bytes_of, carry))
    array: Array = carry
    return int(np.asarray(array).nbytes)
