"""How fast the target is reached."""

from harness_plugins.kit.metrics import recorded_trace
from harness_plugins.metrics.episodes import StepsToTarget


def test_mean_over_the_episodes_that_reach_it():
    """The value is the mean step of the rows where it is reached; the other episodes do not count."""
    trace = recorded_trace(0, ("reached", "truncated", "reached", "ground", ""))
    trace["step"][trace.last_rows] = [10, 1000, 20, 1000]
    assert StepsToTarget()(trace) == 15.0


def test_start_row_is_no_step():
    """An episode with one row after its start took one step."""
    trace = recorded_trace(0, ("reached",))
    assert StepsToTarget()(trace) == len(trace) - 1


def test_first_time_counts():
    """An episode that goes on to other targets took as long as to its first."""
    trace = recorded_trace(0, ("touched",))
    trace["reached"][-1] = True
    assert StepsToTarget()(trace) == 2.0


def test_none_where_no_episode_reaches_it():
    """Where the target is never reached there is no value, rather than 0 or a large one."""
    assert StepsToTarget()(recorded_trace(0, ("truncated", "ground"))) is None
