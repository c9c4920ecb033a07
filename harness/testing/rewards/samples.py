"""What the reward checks hand to a reward."""

import numpy as np

from harness.reward import Array, Carry, Reward, Sample

STEPS, NUM_ENVS = 20, 4
HORIZON = 100
"""Steps of a whole episode of the default task, ``fd100-reach``."""


def random_samples(seed: int, num_envs: int = NUM_ENVS, steps: int = STEPS) -> list[Sample]:
    """The samples of an episode of each env whose distance goes up and down at random; one per step."""
    rng = np.random.default_rng(seed)
    begin = rng.uniform(0.2, 1.0, num_envs)
    best, previous, samples = begin, begin, []
    for step in range(1, steps + 1):
        distance = np.abs(previous + rng.uniform(-0.2, 0.18, num_envs))
        samples.append(sample_of(begin, best, previous, distance, step))
        best, previous = np.minimum(best, distance), distance
    return samples


def edge_samples() -> list[Sample]:
    """The corners: on the target, come onto it, gone from it, standing still, back at the best, back at the start."""
    begin = np.array([0.5, 0.5, 0.5, 0.5, 0.5, 0.5])
    best = np.array([0.0, 0.3, 0.0, 0.3, 0.3, 0.5])
    previous = np.array([0.0, 0.3, 0.0, 0.3, 0.4, 0.6])
    distance = np.array([0.0, 0.0, 0.2, 0.3, 0.3, 0.5])
    return [sample_of(begin, best, previous, distance, step) for step in (1, 2)]


def sample_of(begin: Array, best: Array, previous: Array, distance: Array, step: int) -> Sample:
    """A sample in arrays of its own."""
    delta = distance - best
    return Sample(*(np.array(part) for part in (begin, best, previous, distance, delta, np.full(len(begin), step))))


def pay(reward: Reward, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
    """What the reward pays, numpy's warnings off: it may divide by anything where it then takes another value."""
    with np.errstate(all="ignore"):
        return reward(carry, sample)


def play(reward: Reward, samples: list[Sample]) -> tuple[list[Carry], list[Array]]:
    """An episode: the carry before each step and after the last one, and the values."""
    carries, values = [reward.initial_carry(samples[0].begin_distance)], []
    for sample in samples:
        carry, value = pay(reward, carries[-1], sample)
        carries.append(carry)
        values.append(value)
    return carries, values
