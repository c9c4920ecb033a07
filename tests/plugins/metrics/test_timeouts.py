"""How often the time is over before the target is reached."""

import pytest

from harness_plugins.kit.metrics import recorded_trace
from harness_plugins.metrics.episodes import GroundHits, SuccessRate, Timeouts


@pytest.mark.parametrize(
    ("ends", "share"),
    [
        (("reached", "truncated", "truncated", "ground"), 0.5),
        (("truncated",), 1.0),
        (("ground", "reached"), 0.0),
        (("touched", "truncated", ""), 0.5),
    ],
)
def test_share_of_the_finished_episodes(ends, share):
    """Truncated, the target not reached on the way either."""
    assert Timeouts()(recorded_trace(0, ends)) == share


@pytest.mark.parametrize("seed", range(3))
def test_outcomes_make_one(seed):
    """Reached, on the ground before, and out of time are all that there is, in tasks that go on too."""
    trace = recorded_trace(seed, ("reached", "truncated", "ground", "touched", "ground", "truncated", "truncated"))
    assert sum([metric(trace) for metric in (SuccessRate(), GroundHits(), Timeouts())]) == pytest.approx(1.0)
