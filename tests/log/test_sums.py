"""The two sums over the steps of an episode."""

import numpy as np

from harness.log import OpenEpisodes, episode_sums


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
