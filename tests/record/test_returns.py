"""What episodes were paid."""

import numpy as np
import pytest

from harness.record import OpenEpisodes, trace_of
from harness.record.returns import mean_return


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


def test_return_of_the_events_alone(trace):
    """Without the shaped reward: -1.5 and 9.5."""
    assert mean_return(trace, ("reward_ground", "reward_target", "reward_step")) == 4.0


def test_no_finished_episode_has_no_return(trace):
    """None, not NaN."""
    unfinished = trace.part(slice(4, None))
    assert mean_return(unfinished) is None


def test_sums_do_not_depend_on_pieces():
    """Of random episodes of three envs: by hand, for every length of a piece."""
    rng = np.random.default_rng(3)
    env = rng.integers(0, 3, 500)
    ends = rng.random(500) < 0.1
    number = np.zeros(3, np.int64)
    episode = np.empty(500, np.int64)
    for row in range(500):
        episode[row] = number[env[row]]
        number[env[row]] += ends[row]
    values, keys = rng.normal(size=(500, 2)), env << 32 | episode
    expected = [values[(keys == keys[row]) & (np.arange(500) <= row)].sum(axis=0) for row in np.flatnonzero(ends)]
    for size in (1, 7, 500):
        now, found = OpenEpisodes.none(2), []
        for begin in range(0, 500, size):
            part = slice(begin, begin + size)
            now, _, sums = now.after(env[part], episode[part], ends[part], values[part].T)
            found += [*sums.T]
        np.testing.assert_allclose(found, expected)
        assert len(now.keys) <= 3
