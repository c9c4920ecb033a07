"""Exact tables: learnt by reset and step alone, solved exactly, refused where the world is none."""

import itertools

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Discrete
from numpy.random import default_rng

from harness_plugins.audit.search.behaviour import ROLES
from harness_plugins.audit.search.held_out import act_of
from harness_plugins.audit.search.kept import Kept
from harness_plugins.audit.search.table import key_of, search_tables
from tests.plugins.audit.search.toy_worlds import EnvWorld, Graph, random_graph, told


def solved(world, starts=(0,), budget=50_000):
    """What the tables of some starts find: by start the three by the sum of pay, and the discounted ones."""
    kept = Kept(starts, world.horizon)
    if not search_tables(world, starts, kept.add, budget, default_rng(0)):
        return None
    return [[it.three(0.0, False) for it in of] for of in (kept.plain, kept.discounted)]


def pays(three, name="paid"):
    """What the three are paid; None where there is none."""
    return [of and getattr(of, name) for of in map(three.get, ROLES)]


def actions(three):
    """What the three do."""
    return [of.actions.tolist() for of in map(three.get, ROLES)]


def frozen_lake(make=gymnasium.make, **options):
    """A lake that pays at the goal, which is success."""
    options = {"is_slippery": False, **options}
    return EnvWorld(lambda: make("FrozenLake-v1", **options), lambda after, paid, *_: paid > 0)


def brute(world, start, name):
    """The three numbers of a start, of all sequences of actions."""
    sequences = np.array(list(itertools.product(range(int(world.space.n)), repeat=world.horizon)))
    outcomes = world.play([start] * len(sequences), sequences)
    paid, success = getattr(outcomes, name), outcomes.success
    failing = paid[~success].max() if (~success).any() else None
    if not success.any():
        return [failing, None, None]
    fast = success & (outcomes.time <= 1.1 * outcomes.time[success].min())
    return [failing, paid[success].max(), paid[fast].max()]


@pytest.mark.parametrize("lasting", [False, True], ids=["success ends", "success lasts"])
def test_the_three_numbers_are_those_of_all_sequences(lasting):
    """In graphs drawn at random, over 8 steps of 2 actions each; by both sums."""
    kinds = set()
    for seed in range(12):
        edges = random_graph(seed, lasting=lasting)
        world = EnvWorld(lambda edges=edges: Graph(edges), told, gamma=0.9, horizon=8)
        for name, (three,) in zip(("paid", "discounted"), solved(world), strict=True):
            expected = brute(world, 0, name)
            assert pays(three, name) == pytest.approx(expected), seed
            kinds.add(tuple(it is None for it in expected))
    assert (False, False, False) in kinds


def test_frozen_lake_takes_few_steps():
    """The table of the small lake is learnt in a few hundred steps, checks included; the goal is six steps away."""
    world = frozen_lake()
    (three,), _ = solved(world)
    assert world.taken < 400 + 6 * world.horizon
    assert (pays(three), pays(three, "steps")[1:]) == ([0.0, 1.0, 1.0], [6, 6])


def test_taxi_is_solved_as_its_own_dynamics_say():
    """What the table pays best from 4 starts is what value iteration over the environment's own `P` says."""
    world = EnvWorld(lambda: gymnasium.make("Taxi-v4"), lambda after, paid, *_: paid == 20.0)
    value = np.zeros(500)
    for _ in range(200):
        value = np.array([
            max(pay + (0.0 if end else value[after]) for ((_, after, pay, end),) in row.values())
            for row in world.env.unwrapped.P.values()
        ])  # fmt: skip
    plain, _ = solved(world, range(4))
    assert [it["success"].paid for it in plain] == [value[world.env.reset(seed=start)[0]] for start in range(4)]


class FirstVisits(gymnasium.Wrapper):
    """Pays the first visit of a state in an episode only: a memory that no observation shows."""

    def reset(self, **options):
        """Forget."""
        self.met = set()
        return super().reset(**options)

    def step(self, action):
        """Pay for what was not met in this episode."""
        after, _, *rest = self.env.step(action)
        paid = float(after not in self.met)
        self.met.add(after)
        return after, paid, *rest


class Tired(Graph):
    """Pays for going round, 6 times in an episode at most."""

    def __init__(self):
        super().__init__([[(0, 2.0, False, False), (0, 5.0, True, True), (0, 1.0, True, True)]])

    def reset(self, **options):
        """Begin anew."""
        self.rounds = 0
        return super().reset(**options)

    def step(self, action):
        """Go round."""
        after, paid, *rest = super().step(action)
        self.rounds += action == 0
        return after, paid if self.rounds <= 6 else 0.0, *rest


NO_TABLES = {
    "a reward with a memory": (
        lambda: frozen_lake(lambda *it, **of: FirstVisits(gymnasium.make(*it, **of))),
        8,
        50_000,
    ),
    "a memory that only the best episode meets": (lambda: EnvWorld(Tired, told, horizon=10), 1, 1_000),
    "chance": (lambda: frozen_lake(is_slippery=True), 8, 1_000),
    "chance that one seed repeats": (lambda: frozen_lake(is_slippery=True), 1, 50_000),
    "never the same again": (lambda: EnvWorld(lambda: gymnasium.make("CartPole-v1"), told), 8, 3_500),
    "actions without number": (lambda: EnvWorld(lambda: gymnasium.make("Pendulum-v1"), told), 1, 0),
}


@pytest.mark.parametrize(("make", "starts", "soon"), NO_TABLES.values(), ids=NO_TABLES)
def test_what_is_no_table_is_noticed_soon(make, starts, soon):
    """What contradicts itself, or is never met again, within a few episodes; slips of one seed too."""
    world = make()
    world.succeeds = lambda *_: False
    assert solved(world, range(3, 3 + starts)) is None
    assert world.taken <= soon


class Hidden(Graph):
    """Two doors: the seed draws which one is the exit, and nobody sees it."""

    def __init__(self):
        shut, out = (0, 0.0, False, False), (0, 1.0, True, True)
        self.doors = [[[shut, out]], [[out, shut]]]
        super().__init__(self.doors[0])

    def reset(self, seed=None, options=None):
        """Draw the exit."""
        self.edges = self.doors[seed % 2]
        return super().reset(seed=seed)


def test_what_the_seed_hides_gives_each_start_a_table():
    """Each start's own exit is found."""
    plain, _ = solved(EnvWorld(Hidden, told, horizon=4), (0, 1))
    assert [it["success"].actions.tolist() for it in plain] == [[1], [0]]


def test_dicts_are_keys():
    """Equal parts make equal keys, whatever their order; another part another one."""
    one = {"place": np.array([1, 2]), "load": 3}
    assert key_of(one) == key_of({"load": np.int64(3), "place": np.array([1, 2])})
    assert key_of(one) != key_of({"place": np.array([1, 3]), "load": 3})


@pytest.mark.parametrize("first", [0, 3])
def test_a_search_keeps_the_best_by_both_sums(first):
    """Where waiting pays 2 and finishing 5: 20 of ten steps, 23, and by half of each step 4, and 5 at once.

    A loop is closed by the horizon: the best-paid success goes round until the last step, which is no policy. Also
    where the first action is number 3.
    """

    class Shifted(Graph):
        """Counts actions from `first`."""

        def __init__(self):
            super().__init__([[(0, 2.0, False, False), (0, 5.0, True, True)]])
            self.action_space = Discrete(2, start=first)

        def step(self, action):
            """Do it."""
            return super().step(int(action) - first)

    world = EnvWorld(Shifted, told, gamma=0.5, horizon=10)
    (plain,), (discounted,) = solved(world, (7,), 1_000)
    assert (pays(plain), pays(discounted, "discounted")) == ([20.0, 23.0, 5.0], [4 - 2 * 0.5**9, 5.0, 5.0])
    assert actions(plain) == [[first] * 10, [first] * 9 + [first + 1], [first + 1]]
    _, (taken,) = world.act([7], act_of(plain["failure"].policy, world))
    assert taken.tolist() == [first] * 10
    assert plain["success"].policy is None


def test_five_hundred_states_and_steps_are_solved_in_seconds():
    """On a ring of 500 places whose exit is at 250 a step forth pays 1, one back nothing, and leaving 7.

    In 500 steps a success can go forth and back 124 times on its way, and one that takes 276 steps 12 times.
    """
    ring = [
        [((at + 1) % 500, 1.0, False, False), ((at - 1) % 500, 0.0, False, False), (at, 0.0, False, False)]
        for at in range(500)
    ]
    ring[250][2] = (250, 7.0, True, True)
    (three,), _ = solved(EnvWorld(lambda: Graph(ring), told, gamma=1.0, horizon=500))
    assert pays(three) == [500.0, 250 + 124 + 7, 250 + 12 + 7]


class Hurried(Graph):
    """A row of three places: going on leads to the exit, which pays the less the later it is; all ends in step 6."""

    def __init__(self):
        on = [[(at + 1, 0.0, False, False), (at, 0.1, False, False)] for at in range(2)]
        super().__init__([*on, [(2, 1.0, True, True), (2, 0.1, False, False)]])

    def reset(self, **options):
        """Begin anew."""
        self.steps = 0
        return super().reset(**options)

    def step(self, action):
        """One step, as a Gymnasium of old: the limit terminates."""
        after, paid, end, *rest = super().step(action)
        self.steps += 1
        return after, paid * (1.0 - 0.1 * self.steps) if end else paid, end or self.steps == 6, *rest


def test_where_time_matters_a_state_is_also_when():
    """A limit and falling pay that nobody observes: the three numbers are those of all sequences, and no policies."""
    world = EnvWorld(Hurried, told, gamma=0.9, horizon=8)
    for name, (_, three) in zip(("paid", "discounted"), solved(world, (0, 1)), strict=True):
        assert pays(three, name) == pytest.approx(brute(world, 1, name))
        assert pays(three, "policy") == [None] * 3
