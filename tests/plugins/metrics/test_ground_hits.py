"""How often the arm runs into the ground."""

import pytest

from harness_plugins.kit.metrics import recorded_trace
from harness_plugins.metrics.episodes import GroundHits


@pytest.mark.parametrize(
    ("ends", "share"),
    [
        (("ground", "truncated", "reached", "ground"), 0.5),
        (("ground",), 1.0),
        (("reached", "truncated"), 0.0),
        (("ground", "truncated", ""), 0.5),
    ],
)
def test_share_of_the_finished_episodes(ends, share):
    """The value is the share of finished episodes that end on the ground."""
    assert GroundHits()(recorded_trace(0, ends)) == share
