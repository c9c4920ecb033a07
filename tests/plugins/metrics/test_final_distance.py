"""How far from the target an episode ends."""

import numpy as np

from harness_plugins.kit.metrics import recorded_trace
from harness_plugins.metrics.episodes import FinalDistance


def test_mean_over_the_ends():
    """The value is the mean distance in the last rows of the finished episodes."""
    trace = recorded_trace(0, ("reached", "ground", "truncated", ""))
    trace["distance"][trace.last_rows] = [0.25, 0.5, 1.5]
    assert FinalDistance()(trace) == 0.75


def test_other_rows_do_not_count():
    """Distances on the way are of no matter."""
    trace = recorded_trace(0, ("reached", "truncated"))
    before = FinalDistance()(trace)
    way = np.setdiff1d(np.arange(len(trace)), trace.last_rows)
    trace["distance"][way] = 100.0
    assert FinalDistance()(trace) == before
