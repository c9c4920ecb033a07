"""How often the target is reached."""

import pytest

from harness_plugins.kit.metrics import recorded_trace
from harness_plugins.metrics.episodes import SuccessRate


@pytest.mark.parametrize(
    ("ends", "share"),
    [
        (("reached", "truncated", "reached", "ground"), 0.5),
        (("reached",), 1.0),
        (("ground", "truncated"), 0.0),
        (("reached", "truncated", ""), 0.5),
        (("touched", "truncated"), 0.5),
    ],
)
def test_share_of_the_finished_episodes(ends, share):
    """The value is the share of finished episodes that reach the target, in the end or on the way."""
    assert SuccessRate()(recorded_trace(0, ends)) == share


def test_ground_and_target_at_once_is_a_success():
    """An episode that ends with both is counted as one that reached its target."""
    trace = recorded_trace(0, ("reached",))
    trace["ground"][-1] = True
    assert SuccessRate()(trace) == 1.0


def test_episode_counts_once():
    """However many targets it reaches."""
    trace = recorded_trace(0, ("touched", "truncated"))
    trace["reached"][:4] = True
    assert SuccessRate()(trace) == 0.5
