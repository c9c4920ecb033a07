"""Linear policies: found where balance is needed, the same by the same seed, played again from plain data."""

import json

import gymnasium
import numpy as np
import pytest

from harness_plugins.audit.search.linear import LINEAR, Scales, act_linearly, goals_of, search_linear
from tests.plugins.audit.search.toy_worlds import EnvWorld, Graph, random_graph, told

STARTS = np.arange(8)


class Record:
    """Keeps every episode that a search reports."""

    def __init__(self):
        self.rows, self.actions, self.paid, self.success, self.made_by, self.policies = [], [], [], [], [], []

    def __call__(self, rows, actions, outcomes, made_by, policies):
        """Take in episodes."""
        self.rows += list(rows)
        self.actions += list(actions)
        self.paid += list(outcomes.paid)
        self.success += list(outcomes.success)
        self.made_by += [made_by] * len(rows)
        self.policies += list(policies) or [None] * len(rows)


def cart_pole():
    """Balance; success is that nothing fell."""
    return EnvWorld(lambda: gymnasium.make("CartPole-v1"), lambda after, paid, terminated, info: not terminated)


def searched(world, budget, seed=0):
    """A search and its record."""
    record = Record()
    found = search_linear(world, STARTS, record, budget, np.random.default_rng(seed))
    return found, record


@pytest.fixture(scope="module")
def balanced():
    """A search in CartPole."""
    return searched(cart_pole(), 70_000)


def test_the_pole_stays_up_from_every_start(balanced):
    """500 steps from each of 8 starts by one policy."""
    found, record = balanced
    assert max(it.outcomes.steps.min() for it in found) == 500
    assert len(found) > 1
    assert set(np.array(record.rows)[np.array(record.paid) == 500.0]) == set(STARTS)


def test_a_policy_is_plain_data(balanced):
    """After a way through a file it takes the actions of the record."""
    _, record = balanced
    k = max(range(len(record.paid)), key=lambda k: record.paid[k])
    policy = json.loads(json.dumps(record.policies[k]))
    world = cart_pole()
    _, actions = world.act([STARTS[record.rows[k]]], act_linearly(policy, world))
    assert record.made_by[k] == LINEAR
    assert np.array_equal(actions[0], record.actions[k])


def test_the_same_seed_finds_the_same():
    """Every episode of one search is that of the next; another seed plays others."""
    (_, one), (_, again), (_, other) = (searched(cart_pole(), 2_000, seed) for seed in (0, 0, 1))
    assert one.paid == again.paid != other.paid
    assert one.policies == again.policies


def test_success_is_found_where_pay_leads_away():
    """A hill that pays for staying down is climbed all the same, because length and success are goals too."""

    class Lazy(gymnasium.Wrapper):
        """Pays for a height below the start's."""

        def step(self, action):
            """Pay for depth."""
            after, _, *rest = self.env.step(action)
            return after, -float(np.sin(3 * after[0])), *rest

    world = EnvWorld(
        lambda: Lazy(gymnasium.make("MountainCarContinuous-v0", max_episode_steps=300)),
        lambda after, paid, terminated, info: terminated,
    )
    _, record = searched(world, 60_000)
    assert set(np.array(record.rows)[np.array(record.success)]) == set(STARTS)


def test_nothing_is_tried_where_observations_are_names():
    """A number that only names a state has no scale."""
    world = EnvWorld(lambda: Graph(random_graph(0)), told, horizon=8)
    assert searched(world, 1_000)[0] == []
    assert world.taken == 0


@pytest.mark.parametrize("name", ["Dict", "Box without bounds"])
def test_observations_and_actions_of_other_shapes(name):
    """Dicts of observations are one row; an action without bounds is cut at 1."""
    space = gymnasium.spaces.Box(-np.inf, np.inf, (2,), np.float64)
    seen = gymnasium.spaces.Dict({"far": space, "near": space}) if name == "Dict" else space

    class Any(gymnasium.Env):
        """Observes what its space holds; pays the first number of an action."""

        observation_space, action_space = seen, gymnasium.spaces.Box(-np.inf, np.inf, (2,), np.float32)

        def reset(self, seed=None, options=None):
            """Begin."""
            super().reset(seed=seed)
            self.observation_space.seed(seed)
            return self.observation_space.sample(), {}

        def step(self, action):
            """Pay."""
            assert action.shape == (2,)
            assert action.dtype == np.float32
            return self.observation_space.sample(), float(action[0]), False, False, {}

    _, record = searched(EnvWorld(Any, lambda *_: False, horizon=10), 6_000)
    best = max(paid for paid, by in zip(record.paid, record.made_by, strict=True) if by == LINEAR)
    assert 8.0 < best <= 10.0


def test_scales_are_those_of_all_that_was_seen():
    """Mean and standard deviation as numpy says them, in two portions; a constant has scale 1."""
    rows = np.column_stack([np.random.default_rng(0).normal(3.0, 2.0, 50), np.full(50, 7.0)])
    scales = Scales(2)
    scales.add(list(rows[:20]))
    scales.add(list(rows[20:]))
    mean, scale = scales.now()
    assert mean == pytest.approx(rows.mean(axis=0))
    assert scale == pytest.approx([rows[:, 0].std(), 1.0])


def test_a_measure_is_a_goal_in_the_direction_that_is_known():
    """One where the world knows it, both where it does not."""
    world = cart_pole()
    outcomes, _ = world.act([0], lambda observed: 0)
    outcomes = type(outcomes)(**{**vars(outcomes), "measures": {"height": np.zeros(1), "depth": np.zeros(1)}})
    world.directions = {"height": 1}
    names = [name for name in goals_of(world, outcomes) if "h" in name and name[-1] == "1"]
    assert names == ["height +1", "depth +1", "depth -1"]
