"""Episodes of one env, made of distances."""

import numpy as np
import pytest

from harness.reward import Sample


def _episode(reward, distances):
    begin = np.array([distances[0]])
    carry, best, previous, values = reward.initial_carry(begin), begin, begin, []
    for step, distance in enumerate(np.array(distances[1:])[:, None], start=1):
        sample = Sample(begin, best, previous, distance, distance - best, np.array([float(step)]))
        carry, value = reward(carry, sample)
        values.append(float(value[0]))
        best, previous = np.minimum(best, distance), distance
    return np.array(values)


@pytest.fixture(scope="session")
def episode():
    """What a reward pays at t = 1, 2, ... of an episode with the distances d(0), d(1), ..."""
    return _episode
