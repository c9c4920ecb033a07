"""What an arm meets depends on the seed and its number alone."""

import numpy as np
from numpy.random import default_rng
from numpy.testing import assert_array_equal

import harness
from harness.task import ReachTask


def test_same_seed_same_starts_under_other_rewards(first_observations):
    """Starts and targets of all episodes depend on the seed: neither on the reward nor on the actions."""
    starts = []
    for action_seed, reward in enumerate(("baseline", "arp:k1=2,k2=3")):
        env = harness.make_env("mujoco", "fd100-reach:horizon=3,epsilon=0.001", reward, num_envs=2)
        starts.append(first_observations(env, 5, action_seed))
        env.close()
    assert_array_equal(*starts)


def test_env_of_a_batch_meets_what_it_meets_alone(make, first_observations):
    """What env k meets depends on the seed and k, not on how many envs there are."""
    task = ReachTask(horizon=3, epsilon=0.001)
    small, large = (first_observations(make(num_envs, task), 5, 0) for num_envs in (2, 5))
    assert_array_equal(small, large[:, :2])


def test_envs_of_a_batch_meet_different_things(make, target_of):
    """No two arms of a batch start alike, nor have they the same target."""
    observations, _ = make(4).reset(seed=0)
    assert len(np.unique(observations[:, 0])) == 4
    assert len(np.unique(target_of(observations)[:, 0])) == 4


def test_other_seed_other_starts(make):
    """Two seeds give two starts."""
    env = make()
    first, second = env.reset(seed=1)[0], env.reset(seed=2)[0]
    assert (first != second).any()


def test_reset_without_a_seed_goes_on(make):
    """Episodes after the first one go on with the stream: all different, and the same when all is done again."""
    env = make()
    runs = [[env.reset(seed=1)[0], env.reset()[0], env.reset()[0]] for _ in range(2)]
    assert_array_equal(runs[0], runs[1])
    assert len({observations.tobytes() for observations in runs[0]}) == 3


def test_seeds_may_be_given_one_by_one(make):
    """A list gives each env a seed of its own, whatever its place."""
    env = make(2)
    first, second = env.reset(seed=[7, 8])[0], env.reset(seed=[8, 7])[0]
    assert_array_equal(first, second[::-1])


def test_episodes_without_a_seed_differ_between_envs(make):
    """Two envs that were never seeded start differently."""
    assert (make().reset()[0] != make().reset()[0]).any()


def test_mujoco_batch_is_its_envs_alone():
    """Through the whole env, an arm of a MuJoCo batch lives, bit for bit, as it does alone."""
    runs = []
    for num_envs in (1, 3):
        env = harness.make_env(num_envs=num_envs, task="fd100-reach:horizon=8")
        env.reset(seed=4)
        actions = default_rng(0).uniform(-1.0, 1.0, (20, 1, 6)).astype(np.float32)
        runs.append([env.step(np.repeat(action, num_envs, axis=0))[:2] for action in actions])
        env.close()
    for (alone, paid_alone), (batch, paid) in zip(*runs, strict=True):
        assert_array_equal(alone[0], batch[0])
        assert paid_alone[0] == paid[0]
