"""Linear policies: found where balance is needed, the same by the same seed, played again from plain data."""

import json
from types import SimpleNamespace

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box, Dict
from numpy.random import default_rng

from harness_plugins.audit.search.held_out import act_of
from harness_plugins.audit.search.linear import goals_of, search_linear
from tests.plugins.audit.search.toy_worlds import EnvWorld, Graph, random_graph, told

STARTS = np.arange(8)
LINEAR = "linear policy"


def cart_pole():
    """Balance; success is that nothing fell."""
    return EnvWorld(lambda: gymnasium.make("CartPole-v1"), lambda after, paid, terminated, info: not terminated)


def searched(world, budget, seed=0):
    """What a search found, and every episode that it reported."""
    episodes = []

    def keep(rows, actions, outcomes, made_by, policies):
        for k, (row, taken) in enumerate(zip(rows, actions, strict=True)):
            policy = policies[k] if policies else None
            episodes.append(SimpleNamespace(
                row=row, actions=taken, paid=outcomes.paid[k], success=outcomes.success[k], by=made_by, policy=policy
            ))  # fmt: skip

    return search_linear(world, STARTS, keep, budget, default_rng(seed)), episodes


@pytest.fixture(scope="module")
def balanced():
    """A search in CartPole."""
    return searched(cart_pole(), 70_000)


def test_the_pole_stays_up_from_every_start(balanced):
    """500 steps from each of 8 starts by one policy."""
    found, episodes = balanced
    kept = [[it.row for it in episodes if it.paid == 500.0 and it.policy == policy] for policy in found]
    assert set(STARTS) in map(set, kept)
    assert len(found) > 1


def test_a_policy_is_plain_data(balanced):
    """After a way through a file it takes the actions of the record."""
    best, world = max(balanced[1], key=lambda it: it.paid), cart_pole()
    policy = json.loads(json.dumps(best.policy))
    _, actions = world.act([STARTS[best.row]], act_of(policy, world))
    assert best.by == LINEAR
    assert np.array_equal(actions[0], best.actions)


def test_the_same_seed_finds_the_same():
    """Every episode of one search is that of the next; another seed plays others."""
    one, again, other = ([(it.paid, it.policy) for it in searched(cart_pole(), 2_000, seed)[1]] for seed in (0, 0, 1))
    assert one == again != other


def test_success_is_found_where_pay_leads_away():
    """A hill that pays for staying down is climbed all the same, because length and success are goals too."""
    world = EnvWorld(
        lambda: gymnasium.make("MountainCarContinuous-v0", max_episode_steps=300),
        lambda after, paid, terminated, info: terminated,
        lambda before, action, after, *_: -float(np.sin(3 * after[0])),
    )
    assert {it.row for it in searched(world, 60_000)[1] if it.success} == set(STARTS)


def test_nothing_is_tried_where_observations_are_names():
    """A number that only names a state has no scale."""
    world = EnvWorld(lambda: Graph(random_graph(0)), told, horizon=8)
    assert searched(world, 1_000)[0] == []
    assert world.taken == 0


@pytest.mark.parametrize("is_dict", [True, False])
def test_observations_and_actions_of_other_shapes(is_dict):
    """Dicts of observations are one row; an action without bounds is cut at 1.

    A policy's scale is that of all that was seen: mean and standard deviation; of what never changes, 1.
    """
    space = Box(-np.inf, np.inf, (1,), np.float64)
    spaces = Dict({"far": space, "near": space})

    class Any(gymnasium.Env):
        """Observes a drawn number beside 7; pays the first number of an action."""

        observation_space = spaces if is_dict else Box(-np.inf, np.inf, (2,), np.float64)
        action_space = Box(-np.inf, np.inf, (2,), np.float32)

        def seen(self):
            """By `np_random`."""
            far, near = self.np_random.normal(3.0, 2.0, 1), np.full(1, 7.0)
            return {"far": far, "near": near} if is_dict else np.concatenate([far, near])

        def reset(self, **options):
            """Begin."""
            super().reset(**options)
            return self.seen(), {}

        def step(self, action):
            """Pay."""
            assert (action.shape, action.dtype) == ((2,), np.float32)
            return self.seen(), float(action[0]), False, False, {}

    found, episodes = searched(EnvWorld(Any, lambda *_: False, horizon=10), 6_000)
    assert 24.0 < max(it.paid for it in episodes if it.by == LINEAR) <= 30.0
    policy = found[0]
    assert policy["mean"] == pytest.approx([3.0, 7.0], abs=0.6)
    assert policy["scale"] == pytest.approx([2.0, 1.0], rel=0.3)


def test_a_measure_is_a_goal_in_the_direction_that_is_known():
    """One where the world knows it, both where it does not."""
    world, outcomes = SimpleNamespace(directions={"height": 1}), SimpleNamespace(measures=("height", "depth"))
    assert [name for name in goals_of(world, outcomes) if name[-1] == "1"] == ["height +1", "depth +1", "depth -1"]
