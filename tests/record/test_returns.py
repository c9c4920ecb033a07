"""What episodes were paid."""

import numpy as np
import pytest

from harness.record import OpenEpisodes, trace_of
from harness.record.returns import episode_sums, mean_return


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


def test_a_sum_has_the_bits_of_its_episode_alone():
    """Whatever stands before it, also of steps that pay minus zero."""
    values = np.append(np.random.default_rng(1).normal(size=(990,)), [-0.0] * 10)
    episodes = [*np.split(np.random.default_rng(2).permutation(990), [1, 9, 300]), np.arange(990, 1000)]
    assert repr(episode_sums(values, episodes).tolist()) == repr([float(values[rows].sum()) for rows in episodes])


def test_sums_do_not_depend_on_pieces():
    """Of random episodes of three envs: by hand, for every length of a piece."""
    rng = np.random.default_rng(3)
    env, ends, values = rng.integers(0, 3, 500), rng.random(500) < 0.1, rng.normal(size=(2, 500))
    episode = sum((env == it) * (np.cumsum((env == it) & ends) - ends) for it in range(3))
    own = ((env == env[row]) & (episode == episode[row]) for row in np.flatnonzero(ends))
    expected = [values[:, rows].sum(axis=1) for rows in own]
    for size in (1, 7, 500):
        now, found = OpenEpisodes.none(2), []
        for part in (slice(begin, begin + size) for begin in range(0, 500, size)):
            now, _, sums = now.after(env[part], episode[part], ends[part], values[:, part])
            found += [*sums.T]
        np.testing.assert_allclose(found, expected)
        assert len(now.keys) <= 3
