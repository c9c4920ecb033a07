"""How near to the target an episode comes."""

import pytest

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


@pytest.mark.parametrize("ends", [(), ("",)])
def test_none_without_a_finished_episode(ends):
    """Without an end there is no value."""
    assert ClosestDistance()(recorded_trace(0, ends)) is None


def test_it_is_in_metres_and_better_when_lower():
    """What the report says beside the value."""
    assert (ClosestDistance().unit, ClosestDistance().better) == ("m", "lower")
