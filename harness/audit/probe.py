"""Made-up distances: what no scripted policy does, the reward is asked about as well."""

import numpy as np

from harness.arrays import Float

EACH = 16
"""Episodes of each of the three kinds."""


def probe_distances(low: float, high: float, steps: int = 100) -> Float:
    """Distances of made-up episodes, log-uniform between `low` and `high` [m]; the same at every call.

    A third jumps at random, a third wanders in small steps, a third comes nearer at every step.

    Returns:
        (steps + 1, 48), [m].
    """
    rng = np.random.default_rng(0)
    jumps, approach = rng.uniform(0.0, 1.0, (2, steps + 1, EACH))
    wander = np.cumsum(rng.normal(0.0, 0.05, (steps + 1, EACH)), axis=0) + rng.uniform(0.0, 1.0, EACH)
    folded = np.abs((wander + 1.0) % 2.0 - 1.0)  # reflected at both ends
    parts = [jumps, folded, -np.sort(-approach, axis=0)]
    distances: Float = low * (high / low) ** np.concatenate(parts, axis=1)
    return distances
