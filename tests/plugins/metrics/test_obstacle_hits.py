"""How often the arm runs into an obstacle."""

import pytest

from harness.log import trace_of
from harness_plugins.kit.metrics import recorded_trace
from harness_plugins.metrics.episodes import ObstacleHits


@pytest.mark.parametrize(
    ("ends", "share"),
    [(("obstacle", "truncated", "reached", "ground"), 0.25), (("obstacle",), 1.0), (("ground", "obstacle", ""), 0.5)],
)
def test_share_of_the_finished_episodes(ends, share):
    """The ground is no obstacle."""
    assert ObstacleHits()(recorded_trace(0, ends)) == share


def test_none_where_the_task_has_no_obstacles():
    """There is nothing to hit."""
    trace = recorded_trace(0, ("ground", "reached"))
    without = {name: column for name, column in trace.rows().columns.items() if name != "obstacle"}
    assert ObstacleHits()(trace_of(without)) is None
