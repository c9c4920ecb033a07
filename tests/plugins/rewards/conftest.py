"""Episodes of one env, made of distances."""

from collections.abc import Callable, Sequence

import numpy as np
import pytest

from harness.reward import Reward, Sample


def _episode(reward: Reward, distances: Sequence[float]) -> np.ndarray:
    begin = np.array([distances[0]])
    carry, best, previous, values = reward.initial_carry(begin), begin, begin, []
    for step, distance in enumerate(np.array(distances[1:])[:, None], start=1):
        sample = Sample(begin, best, previous, distance, distance - best, np.array([float(step)]))
        carry, value = reward(carry, sample)
        values.append(float(value[0]))
        best, previous = np.minimum(best, distance), distance
    return np.array(values)


@pytest.fixture(scope="session")
def episode() -> Callable[[Reward, Sequence[float]], np.ndarray]:
    """What a reward pays at t = 1, 2, ... of an episode with the distances d(0), d(1), ..."""
    return _episode
