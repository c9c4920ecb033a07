"""Success weighted by path length."""

import numpy as np
import pytest

from harness_plugins.kit.metrics import recorded_trace
from harness_plugins.metrics.episodes import PathRatio, Spl


def test_success_counts_the_line_over_the_path():
    """For one episode that reaches the target it is 1 over the path ratio."""
    trace = recorded_trace(0, ("reached",))
    assert Spl()(trace) == pytest.approx(1.0 / PathRatio()(trace))


def test_failure_counts_nothing():
    """It is in the mean with 0, whatever ended it; an unfinished episode is not in it."""
    alone = Spl()(recorded_trace(0, ("reached",)))
    assert Spl()(recorded_trace(0, ("reached", "ground", "truncated", ""))) == pytest.approx(alone / 3)


@pytest.mark.parametrize("seed", range(5))
def test_never_above_the_success_rate(seed):
    """Which it is for straight ways."""
    trace = recorded_trace(seed, ("reached", "ground", "touched", "truncated"))
    assert 0.0 < Spl()(trace) <= 0.5
    for axis in "xyz":
        trace[f"end_effector_{axis}"][:] = trace["step"]
    assert Spl()(trace) == pytest.approx(0.5)


def test_way_back_to_the_start_counts_nothing():
    """Its straight line has no length; an arm that never moved is no division by 0."""
    trace = recorded_trace(0, ("reached",))
    for axis in "xyz":
        trace[f"end_effector_{axis}"][:] = 0.0
    assert Spl()(trace) == 0.0


def test_path_ends_where_the_target_is_reached_first():
    """What follows is the way to another target."""
    trace = recorded_trace(0, ("touched",))
    before = Spl()(trace)
    trace["end_effector_x"][3:] += np.arange(len(trace) - 3)
    assert Spl()(trace) == before
