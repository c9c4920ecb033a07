"""Which points of a curve are drawn."""

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float

POINTS = 240
"""The most points that are drawn per curve, one for every second pixel. All steps of all runs would be 100 MB."""

ON_A_PAGE = 80_000
"""The most points of all single runs on a page together, which is about 0.9 MB."""
FEWEST = 40
"""The fewest points of one run: its shape can still be seen."""


def points_of_a_run(runs: int) -> int:
    """How many points a run is drawn with on a page that has so many runs."""
    return max(FEWEST, min(POINTS, ON_A_PAGE // max(1, runs)))


def select_points(values: Float, points: int = POINTS) -> NDArray[np.int64]:
    """Which steps to draw: the first, the last, and the extremes of each stretch between, in order, (<= points,).

    Every stretch keeps its lowest and its highest value, so the drawn curve reaches as far as the real one and crosses
    zero in the same stretches. Averages or every n-th step would not.
    """
    count = len(values)
    if count <= points:
        return np.arange(count)
    stretches = np.array_split(np.arange(count), points // 2 - 1)
    extremes = [stretch[pick(values[stretch])] for stretch in stretches for pick in (np.argmin, np.argmax)]
    return np.unique([0, *extremes, count - 1])
