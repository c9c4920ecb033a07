"""How long it takes until the target is reached, failures included."""

import pytest

from harness.record import EpisodeFacts
from harness.record.trace import with_episode_facts
from harness_plugins.kit.metrics import recorded_trace
from harness_plugins.metrics.episodes import TimeToTarget


def told(trace, horizon=100, period=0.1):
    """The trace with these facts."""
    return with_episode_facts(trace, EpisodeFacts(horizon=horizon, control_period=period))


def test_failure_counts_as_the_whole_horizon():
    """On the ground or out of time; an unfinished episode does not count."""
    trace = recorded_trace(0, ("reached", "truncated", "reached", "ground", ""))
    trace["step"][trace.last_rows] = [10, 7, 20, 8]
    assert TimeToTarget()(told(trace)) == pytest.approx((1.0 + 10.0 + 2.0 + 10.0) / 4)


def test_first_time_counts():
    """An episode that goes on to other targets took as long as to its first."""
    trace = recorded_trace(0, ("touched",))
    trace["reached"][-1] = True
    assert TimeToTarget()(told(trace)) == pytest.approx(0.2)


def test_horizon_is_needed_for_failures_alone():
    """Where all episodes reach the target it changes nothing."""
    good, mixed = (recorded_trace(0, ends) for ends in (("reached",), ("reached", "ground")))
    assert TimeToTarget()(told(good, horizon=None)) == TimeToTarget()(told(good))
    assert TimeToTarget()(told(mixed, horizon=None)) is None


def test_none_without_the_control_period():
    """Steps are no seconds."""
    assert TimeToTarget()(told(recorded_trace(0, ("reached",)), period=None)) is None
