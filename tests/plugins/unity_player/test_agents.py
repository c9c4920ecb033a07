"""Agents of a player over the real protocol: what they observe, are paid, and how they come and go."""

import numpy as np
import pytest
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

from harness.env.vector_env import ReachVectorEnv
from harness.registry import choose
from harness_plugins.environments.unity import Unity
from harness_plugins.kit import IdealSimulator
from tests.refusals import refused
from tests.registered import REGISTRY, UNITY_ARM

SEED = 7


def own_task(reward, horizon=5000):
    """The same task in the harness itself."""
    task = choose(REGISTRY, "tasks", f"unity-reach:horizon={horizon}").build(REGISTRY, "tasks")
    pays = choose(REGISTRY, "rewards", reward).build(REGISTRY, "rewards")
    return ReachVectorEnv(IdealSimulator(), UNITY_ARM, task, pays, 1)


def played(env, steps, seed=SEED):
    """Observations, rewards and ends of random actions."""
    rng, rows = default_rng(seed), []
    observation, _ = env.reset(seed=seed)
    rows.append((observation, 0.0, False, False))
    for _ in range(steps):
        observation, reward, terminated, truncated, _ = env.step(rng.uniform(-1.0, 1.0, 5).astype(np.float32))
        rows.append((observation, reward, terminated, truncated))
        if terminated or truncated:
            rows.append((env.reset()[0], 0.0, False, False))
    return rows


def same(one, other):
    """Whether two plays are equal bit for bit."""
    return all(np.array_equal(a[0], b[0]) and a[1:] == b[1:] for a, b in zip(one, other, strict=True))


@pytest.mark.parametrize("reward", ["baseline", "arp", "aarp"])
def test_rewards_are_those_of_the_same_task_in_the_harness(start, reward):
    """Step by step over many episodes: what is read off observations, and what the program pays beyond."""
    env = start(
        "--positions", places="(end_effector=19:22,target=22:25,renewed=22:25)"[1:-1], steps=5, own_pays="baseline"
    )
    unity = Unity(file="x", places="end_effector=19:22,target=22:25,renewed=22:25", steps=5, own_pays="baseline")
    measure, ours, rng = unity.rewards(env)[reward], own_task(reward), default_rng(SEED)
    observation, _ = env.reset(seed=SEED)
    expected, _ = ours.reset(seed=SEED)
    measure.reset()
    for _ in range(300):
        assert_array_equal(observation[:19], expected[0])
        action = rng.uniform(-1.0, 1.0, 5).astype(np.float32)
        after, _, terminated, truncated, info = env.step(action)
        expected, paid, ends, cuts, _ = ours.step(action[None])
        assert (terminated, truncated) == (ends[0], cuts[0])
        assert measure(observation, action, after, info) == pytest.approx(paid[0], abs=1e-6)
        observation = after
        if terminated or truncated:
            observation, _ = env.reset()
            measure.reset()


def test_the_longest_time_truncates_and_does_not_terminate(start):
    """ML-Agents' max step."""
    assert (False, True) in [row[2:] for row in played(start("--horizon", "10"), 60) if row[2] or row[3]]


def test_a_seed_decides_what_follows(start):
    """In the same player, where the seed comes as an environment parameter."""
    env = start("--horizon", "20")
    assert same(played(env, 20), played(env, 20))


def test_another_seed_is_another_episode(start):
    """Starts and targets differ."""
    env = start()
    assert not np.array_equal(env.reset(seed=1)[0], env.reset(seed=2)[0])


def test_a_seed_starts_the_program_anew_once(start):
    """A program may read its seed only when it starts."""
    env, other = start("--horizon", "20"), start("--horizon", "20")
    assert same(played(env, 20), played(other, 20))


def test_agents_of_one_program_move_together(start):
    """Eight arms of one program do what eight tasks of the harness do, side by side."""
    from harness.environment import announce_all

    envs, rng = start("--agents", "8", "--horizon", "40", count=8), default_rng(SEED)
    rows = [env.reset(seed=SEED + k)[0] for k, env in enumerate(envs)]
    assert len({row.tobytes() for row in rows}) == 8
    ended = 0
    for _ in range(30):
        actions = list(rng.uniform(-1.0, 1.0, (8, 5)).astype(np.float32))
        announce_all(envs, actions)
        for k, (env, action) in enumerate(zip(envs, actions, strict=True)):
            rows[k], _, terminated, truncated, _ = env.step(action)
            assert_allclose(rows[k][:5], action, atol=1e-6)  # it observes its own joint angles
            if terminated or truncated:
                ended += 1
                rows[k], _ = env.reset()
    assert ended > 8


def test_one_env_of_many_agents_leaves_the_others_alone(start):
    """They do nothing."""
    env = start("--agents", "3")
    env.reset(seed=SEED)
    assert env.step(np.full(5, 0.5, np.float32))[0].shape == (19,)


def test_several_programs_are_started_where_one_has_not_enough_agents(start):
    """Each has a port of its own."""
    envs = start("--agents", "2", count=3)
    assert len(envs) == 3
    assert all(env.reset(seed=SEED)[0].shape == (19,) for env in envs)


@pytest.mark.parametrize(("acts", "choices"), [("branches", 3**5), ("choice", 11)])
def test_discrete_actions_move_the_arm(start, acts, choices):
    """One branch and several."""
    env = start("--acts", acts)
    assert env.action_space.n == choices
    before, _ = env.reset(seed=SEED)
    after = env.step(choices - 1)[0]
    assert not np.array_equal(before[:5], after[:5])


def test_a_behaviour_is_named_without_its_team(start):
    """As it stands in the editor."""
    assert start(behavior="Arm").observation_space.shape == (19,)


def test_an_unknown_behaviour_is_refused(start):
    """The message names what there is."""
    with refused(r"behavior=Leg: Unity has no such behaviour. There is: Arm"):
        start(behavior="Leg")


def test_places_beyond_the_observation_are_refused(start):
    """Before anything is trained."""
    with refused(r"places: 19:20 is beyond the 19 numbers that there are"):
        start(places="distance=19:20")
