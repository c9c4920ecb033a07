"""Worlds where chance decides: noticed, counted, solved for policies, and rated on starts that no search has played."""

import json

import gymnasium
import numpy as np
import pytest
from numpy.random import default_rng

from harness_plugins.audit.search.held_out import act_of, search_by_chance, share_interval
from harness_plugins.audit.search.table import decides_by_chance
from tests.plugins.audit.search.toy_worlds import EnvWorld, Graph, told

STARTS = np.arange(4)


class Icy(Graph):
    """A graph in which an action goes wrong one time in four: nothing happens then."""

    def __init__(self, edges, slips=0.25):
        super().__init__(edges)
        self.slips = slips

    def step(self, action):
        """Do it, or slip."""
        if self.np_random.random() < self.slips:
            return self.at, 0.0, False, False, {"success": False}
        return super().step(action)


def icy(edges, gamma=0.95, horizon=20, slips=0.25):
    """A world of it."""
    return EnvWorld(lambda: Icy(edges, slips), told, gamma=gamma, horizon=horizon)


def honest():
    """Two steps lead to the exit, which pays; staying pays nothing."""
    return [[(1, 0.0, False, False), (0, 0.0, False, False)], [(0, 0.0, False, False), (1, 10.0, True, True)]]


def hacked():
    """Going to and fro pays 1 a step, leaving 2."""
    return [[(1, 1.0, False, False), (0, 0.0, False, False)], [(0, 1.0, False, False), (1, 2.0, True, True)]]


def searched(world, budget=10_000):
    """What a search by chance finds."""
    return search_by_chance(world, STARTS, budget, default_rng(0))


@pytest.fixture(scope="module")
def lake():
    """Rates of the slippery lake, and its world."""
    world = EnvWorld(lambda: gymnasium.make("FrozenLake-v1"), lambda after, paid, *_: paid > 0)
    return world, searched(world, 60_000).rates


def solved_by_its_own_dynamics(env, horizon):
    """The largest chance of the goal, by `P`."""
    value = np.zeros(env.unwrapped.observation_space.n)
    for _ in range(horizon):
        value = np.array([
            max(
                sum(p * (paid + (0.0 if end else value[after])) for p, after, paid, end in went)
                for went in row.values()
            )
            for row in env.unwrapped.P.values()
        ])  # fmt: skip
    return value[0]


def test_the_slippery_lake_is_crossed_as_often_as_can_be(lake):
    """The rate on held-out starts is, within its interval, what value iteration over `P` says."""
    world, rates = lake
    _, low, high = share_interval(rates["success"].outcomes.success)
    assert low <= solved_by_its_own_dynamics(world.env, 100) <= high + 0.02
    assert rates["success"].policy["kind"] == "table"
    assert rates["random"].outcomes.success.mean() < 0.1


def test_rates_are_of_held_out_starts(lake):
    """All policies are rated on the same ones, and no search draws these."""
    _, rates = lake
    assert rates["paid"].starts == rates["success"].starts == rates["random"].starts
    assert all(1_000_000 <= start < 2_000_000 for start in rates["paid"].starts)
    assert len(rates["paid"].outcomes.paid) == len(rates["paid"].starts) >= 24


def test_a_rated_policy_is_plain_data(lake):
    """After a way through a file it does the same again."""
    world, rates = lake
    policy = json.loads(json.dumps(rates["success"].policy))
    again, actions = world.act(np.array(rates["success"].starts), act_of(policy, world))
    assert np.array_equal(again.paid, rates["success"].outcomes.paid)
    assert np.array_equal(actions[0], rates["success"].actions)


def test_the_same_seed_rates_the_same():
    """Bit for bit."""
    one, other = (searched(icy(hacked())).rates for _ in range(2))
    assert np.array_equal(one["paid"].outcomes.paid, other["paid"].outcomes.paid)
    assert one["paid"].policy == other["paid"].policy


def test_an_honest_world_has_no_failure_that_pays():
    """The policy that is paid most is the one that succeeds."""
    (three,) = searched(icy(honest())).plain
    assert "failure" not in three
    assert three["success"].paid == pytest.approx(10.0, abs=0.1)
    assert three["success"].time < 5


def test_a_hack_is_a_policy_that_fails_and_is_paid_more():
    """To and fro earns 20 steps of 1, three times in four."""
    found = searched(icy(hacked()))
    (three,) = found.plain
    assert three["failure"].paid == pytest.approx(15.0, abs=1.0)
    assert three["success"].success
    assert three["fastest"].paid < 5.0
    assert (found.how, found.successes[0] >= 8) == (("sampled table",), True)


def test_without_success_what_is_paid_most_is_a_failure():
    """Nothing is said of successes that were never met."""
    edges = [[(0, 1.0, False, False), (0, 0.0, False, False)]]
    (three,) = searched(icy(edges), 5_000).discounted
    assert set(three) == {"failure"}
    assert three["failure"].policy["kind"] == "table"


def test_what_does_not_repeat_itself_gets_linear_policies():
    """CartPole that is never begun twice alike: nothing but policies can be kept of it."""

    class Anew(gymnasium.Wrapper):
        """Ignores seeds."""

        def reset(self, *, seed=None, options=None):
            """Begin anywhere."""
            return super().reset(options=options)

    def anew():
        env = Anew(gymnasium.make("CartPole-v1", max_episode_steps=100))
        env.env.reset(seed=0)
        return env

    world = EnvWorld(anew, lambda after, paid, terminated, info: not terminated, horizon=100)
    world.is_repeated = False
    rates = searched(world, 60_000).rates
    assert rates["success"].policy["kind"] == "linear policy"
    assert rates["success"].outcomes.success.mean() > 0.9


@pytest.mark.parametrize("name", ["CartPole-v1", "Taxi-v4"])
def test_worlds_that_seeds_decide_are_not_chance(name):
    """The same begin and choices bring the same; nothing is rated then."""
    assert searched(EnvWorld(lambda: gymnasium.make(name), lambda *_: False), 20_000) is None


def test_slips_are_chance():
    """Also those that begin in many states, as in a rainy taxi, as long as some begin alike."""
    rainy = EnvWorld(lambda: gymnasium.make("Taxi-v4", is_rainy=True), lambda *_: False)
    assert decides_by_chance(rainy, 20_000, default_rng(0))


def test_interval_of_a_share_is_wilsons():
    """As its page gives it."""
    z, p, n = 1.959964, 0.3, 20
    middle, half = p + z**2 / (2 * n), z * np.sqrt(p * (1 - p) / n + z**2 / (4 * n**2))
    expected = ((middle - half) / (1 + z**2 / n), (middle + half) / (1 + z**2 / n))
    assert share_interval(np.arange(20) < 6)[1:] == pytest.approx(expected, abs=1e-6)
