"""What episodes were paid."""

import numpy as np
import pytest

from harness.log import trace_of
from harness.record.trace import mean_return


@pytest.fixture
def trace():
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


def test_return_has_all_that_was_paid(trace):
    """Shaped reward and events of the finished episodes: 0.5 and 13.5."""
    assert mean_return(trace) == 7.0


def test_no_finished_episode_has_no_return(trace):
    """None, not NaN."""
    unfinished = trace.part(slice(4, None))
    assert mean_return(unfinished) is None
