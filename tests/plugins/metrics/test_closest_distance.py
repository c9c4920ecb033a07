"""How near to the target an episode comes."""

from harness_plugins.kit.metrics import recorded_trace
from harness_plugins.metrics.episodes import ClosestDistance


def test_mean_over_the_smallest_distances():
    """Of each finished episode the row that is nearest counts, wherever it is; one that goes on does not count."""
    trace = recorded_trace(0, ("reached", "ground", "truncated", ""))
    trace["distance"][:] = 5.0
    for rows, closest in zip(trace.episodes, [0.25, 0.5, 1.5], strict=True):
        trace["distance"][rows[len(rows) // 2]] = closest
    trace["distance"][-1] = 0.0
    assert ClosestDistance()(trace) == 0.75
