"""What shows after many steps: values that leave the numbers, a carry that grows, memory that is never given back."""

import numpy as np

from harness.reward import Array, Carry, Reward
from harness.testing.memory import require_nothing_kept
from harness.testing.rewards.samples import HORIZON, joints_of, pay, play, random_samples, samples_for, values_of
from harness.testing.violations import check, require

STEPS = 5_000
"""The steps of an episode of the longest built-in task, ``unity-reach``."""
EPISODES = 10


@check("reward-long-run")
def a_long_episode_is_paid(reward: Reward) -> None:
    """In an episode of 5,000 steps every value is finite, and the carry stays as large as it was in the beginning."""
    samples = samples_for(reward, 0, steps=STEPS)
    carries, paid = play(reward, samples[:HORIZON])
    carry, size = carries[-1], _bytes_of(carries[-1])
    is_known = not all(np.isfinite(value).all() for of in paid for value in values_of(of).values())  # another check's
    for step, sample in enumerate(samples[HORIZON:], HORIZON + 1):
        carry, of = pay(reward, carry, sample)
        for name, value in values_of(of).items():
            require(is_known or np.isfinite(value).all(), "{} of step {} is {}", name, f"{step:,}", value)
    grown = _bytes_of(carry)
    require(grown <= size, f"the carry has {size} bytes after {HORIZON} steps, {grown} after {STEPS:,}: it grows")


@check("reward-leak")
def nothing_is_kept_of_a_step(reward: Reward) -> None:
    """Only the carry remembers a step: the memory that the reward takes does not grow from episode to episode."""
    joints = joints_of(reward)

    def play_episodes() -> None:
        for seed in range(EPISODES):
            play(reward, random_samples(seed, steps=HORIZON, joints=joints))

    require_nothing_kept(play_episodes, EPISODES * HORIZON, "steps")


def _bytes_of(carry: Carry) -> int:
    if isinstance(carry, tuple):
        return sum(map(_bytes_of, carry))
    array: Array = carry
    return int(np.asarray(array).nbytes)
