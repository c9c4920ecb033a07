"""What episodes were paid."""

import numpy as np
import pytest

from harness.log import Log
from harness.record.returns import EVENTS, mean_over_episodes, mean_return
from harness.record.trace import trace_of


@pytest.fixture
def trace() -> Log:
    """Two finished episodes in two envs, their rows mixed, and one that goes on."""
    columns = {
        "env": [0, 1, 0, 1, 1],
        "episode": [0, 0, 0, 0, 1],
        "terminated": [False, False, True, False, False],
        "truncated": [False, False, False, True, False],
        "reward": [0.0, 0.0, 2.0, 4.0, 100.0],
        "reward_ground": [0.0, 0.0, -1.0, 0.0, 50.0],
        "reward_target": [0.0, 0.0, 0.0, 10.0, 0.0],
        "reward_step": [0.0, 0.0, -0.5, -0.5, 0.0],
    }
    return trace_of({name: np.array(values) for name, values in columns.items()})


def test_return_has_all_that_was_paid(trace: Log):
    """Shaped reward and events of the finished episodes: 0.5 and 13.5."""
    assert mean_return(trace) == 7.0


def test_return_of_the_events_alone(trace: Log):
    """Without the shaped reward: -1.5 and 9.5."""
    assert mean_return(trace, EVENTS) == 4.0


def test_other_values_are_summed_per_episode(trace: Log):
    """One value per row, whatever it stands for."""
    assert mean_over_episodes(np.array([0.0, 0.0, 1.0, 5.0, 7.0]), trace) == 3.0


def test_no_finished_episode_has_no_return(trace: Log):
    """None, not NaN."""
    unfinished = trace.part(slice(4, None))
    assert mean_return(unfinished) is None
