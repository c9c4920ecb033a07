"""Exact tables: learnt by reset and step alone, solved exactly, refused where the world is none."""

import itertools

import gymnasium
import numpy as np
import pytest

from harness_plugins.audit.search.table import Solved, act_by_table, key_of, learn_tables, search_tables
from tests.plugins.audit.search.toy_worlds import EnvWorld, Graph, random_graph, told


def tables_of(world, starts=(0,), budget=50_000):
    """The tables of some starts."""
    return learn_tables(world, starts, budget, np.random.default_rng(0))


def learnt(world):
    """The table of start 0."""
    return tables_of(world)[0]


def best_of(table, start, horizon, gamma):
    """The actions of the best episodes."""
    return [best.actions for best in Solved(table, horizon, gamma).bests(start)]


def frozen_lake(**options):
    """A lake that pays at the goal, which is success."""
    options = {"is_slippery": False, **options}
    return EnvWorld(lambda: gymnasium.make("FrozenLake-v1", **options), lambda after, paid, *_: paid > 0)


def brute(world, start, discounted=False):
    """The three numbers of a start, of all sequences of actions."""
    sequences = np.array(list(itertools.product(range(int(world.space.n)), repeat=world.horizon)))
    outcomes = world.play([start] * len(sequences), sequences)
    paid, success = outcomes.discounted if discounted else outcomes.paid, outcomes.success
    failing = paid[~success].max() if (~success).any() else None
    if not success.any():
        return [failing, None, None]
    fast = success & (outcomes.time <= 1.1 * outcomes.time[success].min())
    return [failing, paid[success].max(), paid[fast].max()]


def numbers(world, table, start, discounted=False):
    """The same three, of what a table says when it is played."""
    found = best_of(table, start, world.horizon, world.gamma if discounted else 1.0)
    padded = np.zeros((len(found), world.horizon), int)
    for row, actions in zip(padded, found, strict=True):
        row[: len(actions)] = actions
    outcomes = world.play([start] * len(found), padded)
    paid = list(outcomes.discounted if discounted else outcomes.paid)
    if not outcomes.success.any():
        return [*paid, None, None]
    return paid if not outcomes.success[0] else [None, *paid]


@pytest.mark.parametrize("lasting", [False, True], ids=["success ends", "success lasts"])
@pytest.mark.parametrize("discounted", [False, True], ids=["plain", "discounted"])
def test_the_three_numbers_are_those_of_all_sequences(lasting, discounted):
    """In graphs drawn at random, over 8 steps of 2 actions each."""
    kinds = set()
    for seed in range(12):
        edges = random_graph(seed, lasting=lasting)
        world = EnvWorld(lambda edges=edges: Graph(edges), told, gamma=0.9, horizon=8)
        expected = brute(world, 0, discounted)
        assert numbers(world, learnt(world), 0, discounted) == pytest.approx(expected, nan_ok=True), seed
        kinds.add(tuple(it is None for it in expected))
    assert (False, False, False) in kinds


def test_frozen_lake_takes_few_steps():
    """The table of the small lake is learnt in a few hundred steps, checks included; the goal is six steps away."""
    world = frozen_lake()
    table = learnt(world)
    assert world.taken < 400
    failure, success, fastest = best_of(table, 0, world.horizon, 1.0)
    assert len(fastest) == len(success) == 6
    assert world.show(0, success).paid.sum() == 1.0
    assert world.show(0, failure).paid.sum() == 0.0


def test_taxi_is_solved_as_its_own_dynamics_say():
    """What the table pays best from 4 starts is what value iteration over the environment's own `P` says."""
    world = EnvWorld(lambda: gymnasium.make("Taxi-v4"), lambda after, paid, *_: paid == 20.0)
    table = tables_of(world, range(4))[0]
    value = np.zeros(500)
    for _ in range(200):
        value = np.array(
            [
                max(pay + (0.0 if end else value[after]) for ((_, after, pay, end),) in row.values())
                for row in world.env.unwrapped.P.values()
            ]
        )
    for start in range(4):
        _, success, _ = best_of(table, start, world.horizon, 1.0)
        assert world.show(start, success).paid.sum() == value[world.env.reset(seed=start)[0]]


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


def test_a_reward_with_a_memory_is_no_table():
    """What is paid the first time only contradicts itself."""
    world = EnvWorld(lambda: FirstVisits(gymnasium.make("FrozenLake-v1", is_slippery=False)), lambda *_: False)
    assert tables_of(world) == {}


def test_chance_is_no_table():
    """On slippery ice the same action leads elsewhere; that is noticed within a few episodes."""
    world = frozen_lake(is_slippery=True)
    assert tables_of(world, range(8)) == {}
    assert world.taken < 1_000


def test_a_world_that_is_never_the_same_again_is_left_alone_soon():
    """CartPole's states are real numbers."""
    world = EnvWorld(lambda: gymnasium.make("CartPole-v1"), lambda *_: False)
    assert tables_of(world, range(8)) == {}
    assert world.taken < 3_000


def test_actions_without_number_are_no_table():
    """Nothing is played in a world whose actions are a box."""
    world = EnvWorld(lambda: gymnasium.make("Pendulum-v1"), lambda *_: False)
    assert tables_of(world) == {}
    assert world.taken == 0


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
    world = EnvWorld(Hidden, told, horizon=4)
    tables = tables_of(world, (0, 1))
    assert [best_of(tables[start], start, 4, 1.0)[1] for start in (0, 1)] == [[1], [0]]


def test_a_loop_is_closed_by_the_horizon():
    """Where going round pays 2 and finishing 5, the best-paid success goes round until the last step."""
    edges = [[(0, 2.0, False, False), (0, 5.0, True, True)]]
    world = EnvWorld(lambda: Graph(edges), told, horizon=10)
    failure, success, fastest = best_of(learnt(world), 0, 10, 1.0)
    assert (failure, success, fastest) == ([0] * 10, [0] * 9 + [1], [1])


def test_dicts_are_keys():
    """Equal parts make equal keys, whatever their order; another part another one."""
    one = {"place": np.array([1, 2]), "load": 3}
    assert key_of(one) == key_of({"load": np.int64(3), "place": np.array([1, 2])})
    assert key_of(one) != key_of({"place": np.array([1, 3]), "load": 3})


class Kept:
    """Keeps every episode that a search reports."""

    def __init__(self):
        self.episodes = []

    def __call__(self, rows, actions, outcomes, made_by, policies):
        """Take in episodes."""
        assert made_by == "table"
        self.episodes += zip(rows, actions, outcomes.paid, outcomes.discounted, outcomes.success, policies, strict=True)


@pytest.mark.parametrize("first", [0, 3])
def test_a_search_keeps_the_best_by_both_sums(first):
    """Where waiting pays 2 and finishing 5: 20 of ten steps, 23, and by half of each step 4, and 5 at once.

    Also where the first action is number 3.
    """

    class Shifted(Graph):
        """Counts actions from `first`."""

        def __init__(self):
            super().__init__([[(0, 2.0, False, False), (0, 5.0, True, True)]])
            self.action_space = gymnasium.spaces.Discrete(2, start=first)

        def step(self, action):
            """Do it."""
            return super().step(int(action) - first)

    world, kept = EnvWorld(Shifted, told, gamma=0.5, horizon=10), Kept()
    assert search_tables(world, (7,), kept, 1_000, np.random.default_rng(0))
    failures, successes = ([it for it in kept.episodes if it[4] == success] for success in (False, True))
    assert max(it[2] for it in failures) == 20.0
    assert max(it[2] for it in successes) == 23.0
    assert max(it[3] for it in failures) == pytest.approx(4 - 2 * 0.5**9)
    assert max(it[3] for it in successes) == 5.0
    policies = [it[5] for it in failures]
    _, (actions,) = world.act([7], act_by_table(policies[0]))
    assert actions.tolist() == [first] * 10
    assert [it[5] for it in successes if it[2] == 23.0] == [None]


def test_a_memory_that_only_the_best_episode_meets_is_noticed():
    """A reward that pays nothing more after 6 rounds is met when the table is played, at the latest."""

    class Tired(Graph):
        """Pays for going round, 6 times in an episode at most."""

        def reset(self, seed=None, options=None):
            """Begin anew."""
            self.rounds = 0
            return super().reset(seed=seed)

        def step(self, action):
            """Go round."""
            after, paid, *rest = super().step(action)
            self.rounds += action == 0
            return after, paid if self.rounds <= 6 else 0.0, *rest

    edges = [[(0, 2.0, False, False), (0, 5.0, True, True), (0, 1.0, True, True)]]
    world = EnvWorld(lambda: Tired(edges), told, horizon=10)
    assert not search_tables(world, (0,), Kept(), 1_000, np.random.default_rng(0))


def test_five_hundred_states_and_steps_are_solved_in_seconds():
    """On a ring of 500 places whose exit is at 250 a step forth pays 1, one back nothing, and leaving 7.

    In 500 steps a success can go forth and back 124 times on its way, and one that takes 276 steps 12 times.
    """
    out, shut = (250, 7.0, True, True), lambda at: (at, 0.0, False, False)
    ring = [
        [((at + 1) % 500, 1.0, False, False), ((at - 1) % 500, 0.0, False, False), out if at == 250 else shut(at)]
        for at in range(500)
    ]
    table = learnt(EnvWorld(lambda: Graph(ring), told, horizon=500))
    failure, success, fastest = Solved(table, 500, 1.0).bests(0)
    assert (failure.paid, success.paid, fastest.paid) == (500.0, 250 + 124 + 7, 250 + 12 + 7)


class Hurried(Graph):
    """A row of three places: going on leads to the exit, which pays the less the later it is; all ends in step 6."""

    def __init__(self):
        on = [[(at + 1, 0.0, False, False), (at, 0.1, False, False)] for at in range(2)]
        super().__init__([*on, [(2, 1.0, True, True), (2, 0.1, False, False)]])

    def reset(self, seed=None, options=None):
        """Begin anew."""
        self.steps = 0
        return super().reset(seed=seed)

    def step(self, action):
        """One step, as a Gymnasium of old: the limit terminates."""
        after, paid, end, *rest = super().step(action)
        self.steps += 1
        return after, paid * (1.0 - 0.1 * self.steps) if end else paid, end or self.steps == 6, *rest


@pytest.mark.parametrize("discounted", [False, True])
def test_where_time_matters_a_state_is_also_when(discounted):
    """A limit and falling pay that nobody observes: the three numbers are those of all sequences."""
    world = EnvWorld(Hurried, told, gamma=0.9, horizon=8)
    table = tables_of(world, (0, 1))[1]
    assert numbers(world, table, 1, discounted) == pytest.approx(brute(world, 1, discounted))
    assert [it.policy for it in Solved(table, 8, 1.0).bests(0)] == [None] * 3


def test_what_chance_brings_one_seed_is_no_table_of_it():
    """Seen with the time, slips of one seed are the same again; a plan that knows them would be clairvoyant."""
    assert tables_of(frozen_lake(is_slippery=True), (3,)) == {}
