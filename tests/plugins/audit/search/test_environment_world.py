"""Anybody's environment as a search plays it: with reset and step alone, and paid as a training is."""

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box, Dict, Discrete, Sequence, Text
from numpy.testing import assert_allclose, assert_array_equal, assert_equal

from harness import RecordRewards
from harness.recorder.env_facts import Columns
from harness.registry import choose
from harness_plugins.audit import find_cheats
from harness_plugins.audit.search.environment_world import of_env
from harness_plugins.audit.search.place import places_in_environment, world_at
from tests.plugins.audit.cases.ships import WAYS, Ships
from tests.refusals import refused
from tests.registered import REGISTRY

LENGTH = 6


class Dock(gymnasium.Env):
    """A ship on a line, begun somewhere by the seed; info tells ``docked``, and at the end ``is_success``."""

    def __init__(self, action_space=None, length=LENGTH):
        self.observation_space = Dict({"at": Box(-9.0, 9.0, (1,), np.float64), "lamp": Discrete(2)})
        self.action_space = action_space or Box(-1.0, 1.0, (1,), np.float64)
        self.length = length

    def seen(self):
        """Where it is, and whether a lamp shines."""
        return {"at": np.array([self.at]), "lamp": int(abs(self.at) < 0.5)}

    def reset(self, **options):
        super().reset(**options)
        self.at, self.count = self.np_random.uniform(-2.0, 2.0), 0
        return self.seen(), {"docked": 0.0}

    def step(self, action):
        assert self.action_space.contains(action)
        self.at, self.count = self.at + float(np.sum(action)), self.count + 1
        docked = float(abs(self.at) < 0.5)
        ended = self.count == self.length
        info = {"docked": docked, **({"is_success": docked} if ended else {})}
        return self.seen(), -abs(self.at), False, ended, info


class Forgetful(Dock):
    """Its seed says nothing of where it begins."""

    count_of_resets = 0

    def reset(self, *, seed=None, options=None):
        Forgetful.count_of_resets += 1
        return super().reset(seed=seed + Forgetful.count_of_resets)


class Leaking(Dock):
    """The same start comes again in a new env only."""

    offset = 0.0

    def reset(self, *, seed=None, options=None):
        seen, info = super().reset(seed=seed)
        self.at += self.offset
        self.offset += 1e-12
        return seen, info


class Late:
    """A reward with a memory: pays the number of the step."""

    def reset(self):
        self.count = 0

    def __call__(self, step):
        self.count += 1
        return {"late": float(self.count), "effort": -0.1 * float(np.sum(np.abs(step.action)))}


def near(observation, action, next_observation, info):
    """Pays what was gained."""
    return abs(float(observation["at"][0])) - abs(float(next_observation["at"][0]))


def gap(step):
    """How far away the ship is."""
    return abs(float(step.observation["at"][0]))


def rewards():
    """What the env pays, functions, memories and terms."""
    return {"own": "own", "near": near, "late": Late(), "lit": {"docked": "docked", "near": near}}


def world_of(make=Dock, reward="own", behaviour=None, lower=(), higher=(), **options):
    """A world of ships."""
    behaviour = {"docked": "docked", "gap": gap} if behaviour is None else behaviour
    return of_env(make, reward, Columns(rewards(), behaviour, lower, higher), 0.9, **options)


def drawn(world, count):
    """Random actions of so many episodes."""
    world.space.seed(0)
    return np.stack([[world.space.sample() for _ in range(world.horizon)] for _ in range(count)])


@pytest.mark.parametrize(
    ("reward", "terms"),
    [("own", ["reward"]), ("near", ["reward"]), ("late", ["late", "effort"]), ("lit", ["docked", "near"])],
)
def test_pay_is_what_a_training_is_paid(reward, terms, tmp_path):
    """Bit for bit, of the env's own pay, functions, memories and terms; a reward without any has one."""
    world = world_of(reward=reward)
    actions, starts = drawn(world, 3), np.array([4, 5, 4])
    env = RecordRewards(Dock(), tmp_path / "steps", trained_with=reward, pay=True, rewards=rewards())
    outcomes = world.play(starts, actions)
    for number, start in enumerate(starts.tolist()):
        env.reset(seed=start)
        paid = [float(env.step(action)[1]) for action in actions[number]]
        shown = world.show(start, actions[number])
        assert (shown.paid.tolist(), [*shown.terms]) == (paid, terms)
        assert outcomes.paid[number] == np.sum(paid)
        assert_allclose(sum(shown.terms.values()), paid)
        assert outcomes.discounted[number] == pytest.approx(sum(it * 0.9**t for t, it in enumerate(paid)))
    env.close()
    assert world.taken == 2 * 3 * LENGTH


def test_time_and_share_by_hand():
    """In at once, out again, and in from the fourth step on."""
    world = world_of()
    at, _ = Dock().reset(seed=2)
    to, out = -at["at"][0], 1.0
    assert abs(to) < 1.0
    actions = np.array([[to], [out], [0.0], [-out], [0.0], [0.0]])
    outcomes, shown = world.play(np.array([2]), actions[None]), world.show(2, actions)
    assert shown.success.tolist() == [True, False, False, True, True, True]
    assert (outcomes.success[0], outcomes.time[0], outcomes.share[0]) == (True, 4, 4 / 6)
    left = world.play(np.array([2]), np.array([[[to], [out], *[[0.0]] * 4]]))
    assert (left.success[0], left.time[0], left.share[0]) == (False, LENGTH, 1 / 6)


def test_measures_have_the_last_value():
    """NaN where info does not tell one. Observations of any space are flat: one number, and two for the lamp."""
    world, env = world_of(behaviour={"docked": "docked", "gap": gap, "done": "is_success"}), Dock()
    actions = drawn(world, 1)
    shown = world.show(0, actions[0])
    outcomes = world.play(np.array([0]), actions)
    env.reset(seed=0)
    for action in shown.actions:
        env.step(action)
    assert outcomes.measures["gap"][0] == shown.measures["gap"][-1] == abs(env.at)
    assert np.isnan(shown.measures["done"]).tolist() == [True] * 5 + [False]
    assert outcomes.trails[0].shape == (LENGTH + 1, 3)


@pytest.mark.parametrize(
    ("behaviour", "asked", "found"),
    [
        ({"success": gap, "docked": "docked"}, {}, "success"),
        ({"gap": gap, "docked": "docked"}, {}, "docked"),
        ({"gap": gap}, {}, "is_success"),
        ({}, {}, "is_success"),
        ({"gap": gap}, {"success": "gap<0.5"}, "gap<0.5"),
        ({}, {"success": "docked"}, "docked"),
        ({"docked": "docked"}, {"lower": ("docked",)}, "is_success"),
    ],
)
def test_what_tells_success(behaviour, asked, found):
    """The measure of that name, a flag, what the user says, or what info tells, and that is told.

    A flag of which less is better, as falling, is no success.
    """
    world = world_of(behaviour=behaviour, **asked)
    assert world.success == found
    assert any("is_success" in line for line in world.notes) == (found == "is_success")


def test_nothing_tells_success():
    """Then nothing is a success, and the name of what tells it is empty."""
    world = of_env("CartPole-v1", "own", Columns({"own": "own"}, {}, ()), 0.99)
    outcomes = world.play(np.arange(2), np.zeros((2, world.horizon), int))
    assert (world.success, outcomes.success.any(), np.isnan(outcomes.near).all()) == ("", False, True)


def test_an_unknown_measure_of_success_is_refused():
    """The nearest name is told."""
    with refused(r"success 'dokked'.*docked"):
        world_of(success="dokked")


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"success": "gap<0.5"}, lambda gaps: -gaps.min()),
        ({"success": "gap>0.5"}, lambda gaps: gaps.max()),
        ({"lower": ("gap",)}, lambda gaps: -gaps.min()),
        ({"higher": ("gap",)}, lambda gaps: gaps.max()),
        ({"lower": ("gap",), "higher": ("gap",)}, lambda gaps: np.nan),
        ({}, lambda gaps: np.nan),
    ],
)
def test_how_near_an_episode_came(options, expected):
    """By the number that a rule compares, or the first whose direction is known."""
    world = world_of(**options)
    actions = drawn(world, 1)
    gaps = world.show(0, actions[0]).measures["gap"]
    assert_equal(world.play(np.array([0]), actions).near[0], expected(gaps))


def test_observed_goals_tell_how_near_an_episode_came():
    """Where no measure does."""

    class Goals(gymnasium.ObservationWrapper):
        def __init__(self):
            super().__init__(Dock())
            space = Box(-9.0, 9.0, (1,), np.float64)
            self.observation_space = Dict({"achieved_goal": space, "desired_goal": space})

        def observation(self, observation):
            return {"achieved_goal": observation["at"], "desired_goal": np.ones(1)}

    world = world_of(Goals, behaviour={})
    outcomes = world.play(np.array([0]), drawn(world, 1))
    (trail,) = outcomes.trails
    assert outcomes.near[0] == pytest.approx(-np.abs(trail[1:, 0] - trail[1:, 1]).min())


@pytest.mark.parametrize(("make", "is_repeated"), [(Dock, True), (Forgetful, False), (Leaking, False)])
def test_an_env_whose_reset_does_not_repeat_is_told(make, is_repeated):
    """At another reset of the same env too."""
    assert world_of(make).is_repeated is is_repeated


@pytest.mark.parametrize(("make", "is_told"), [(Dock, False), (Forgetful, True)])
def test_why_no_sequences_were_searched_is_told(make, is_told):
    """Where a seed does not bring the same again."""
    (finding,) = find_cheats(
        make, {"own": "own"}, behaviour={"gap": gap}, success="gap<0.5", budget=2_000, starts=1
    ).cheats
    assert any("do not bring the same again" in line for line in finding.lines) == is_told


def test_a_reward_that_draws_is_not_repeated():
    """From the generator of the whole process."""
    assert not of_env(Dock, "noisy", Columns({"noisy": lambda step: np.random.rand()}, {}, ()), 0.9).is_repeated


def test_one_env_is_left_open():
    """Nobody else's env is closed, and it is asked alone."""
    env = Dock()
    env.close = lambda: pytest.fail("it was closed")
    world = world_of(env)
    assert world.is_repeated
    world.close()


def test_an_env_without_a_limit_is_cut():
    """And that is told."""
    world = world_of(lambda: Dock(length=10_000))
    actions = drawn(world, 1)
    assert (world.horizon, world.play(np.array([0]), actions).steps[0]) == (500, 500)
    assert "cut after 500 steps" in world.notes[-1]
    assert world.show(0, actions[0]).ended == "cut"


@pytest.mark.parametrize("flags", [(False, True), (True, False)])
def test_an_env_that_counts_steps_itself_is_asked_for_its_limit(flags):
    """Whether it calls the end of time a truncation or a termination."""

    class Counting(Dock):
        def step(self, action):
            seen, paid, *_, info = super().step(action)
            ended = self.count == self.length
            return seen, paid, ended and flags[0], ended and flags[1], info

    world = world_of(Counting)
    assert (world.horizon, world.notes[1:]) == (LENGTH, ())


def test_ends_that_behaviour_brings_are_no_limit():
    """As falling over."""

    class Falling(Dock):
        def step(self, action):
            seen, paid, _, ended, info = super().step(action)
            return seen, paid, abs(self.at) > 2.5, ended, info

    assert world_of(lambda: Falling(length=10_000)).horizon == 500


def test_flat_actions_of_a_matrix():
    """An action of two rows is four numbers."""
    world = world_of(lambda: Dock(Box(-1.0, 1.0, (2, 2), np.float32)))
    assert (world.space.shape, world.space.dtype) == ((4,), np.float32)
    assert world.show(0, drawn(world, 1)[0]).actions.shape == (LENGTH, 4)


@pytest.mark.parametrize("space", [Text(3), Dict({"say": Text(3), "go": Discrete(2)}), Sequence(Discrete(2))])
def test_actions_beside_choices_and_numbers_are_refused(space):
    """With what is taken."""
    with refused("cannot be searched: its actions are .*A search takes Discrete"):
        world_of(lambda: Dock(space))


@pytest.mark.parametrize("takes", WAYS)
def test_actions_of_a_policy_reach_the_env_as_they_are(takes):
    """However they are coded, and again where they are played from the code."""
    env = Ships(takes).make()
    space, taken = env.action_space, []
    env.unwrapped.moves = lambda action: taken.append(action) or 0.0
    world = of_env(env, "own", Columns({"own": "own"}, {}, ()), 0.9)
    space.seed(0)
    given = [space.sample() for _ in range(world.horizon)]
    drawn = iter(given)
    taken.clear()
    _, (codes,) = world.act(np.array([0]), lambda seen: world.written(next(drawn)))
    world.show(0, codes)
    assert_equal(taken, given * 2)


def test_choices():
    """Actions of an env with choices are whole numbers, also those of a policy."""
    world = world_of(lambda: Dock(Discrete(2)))
    outcomes, taken = world.act(np.arange(3), lambda seen: np.int64(seen["lamp"]))
    assert taken[0].shape == (outcomes.steps[0],)
    assert_array_equal(world.play(np.arange(3), np.stack(taken)).paid, outcomes.paid)


def test_a_reward_that_fails_is_named():
    """With the start and the step."""

    def broken(step):
        return 1.0 / (1 - len(step.info) // 2)

    with refused("reward 'broken' failed in the episode of start 0, step 6: ZeroDivisionError"):
        of_env(Dock, "broken", Columns({"broken": broken}, {}, ()), 0.9)


def test_an_environment_of_a_plugin():
    """By its name, with the limit that its id says."""
    task = choose(REGISTRY, "environments", "gymnasium:id=Pendulum-v1")
    world = world_at(places_in_environment(REGISTRY, task, ["own"], 0.99)[0], REGISTRY)
    assert (world.name, world.reward, world.horizon) == (task.label, "own", 200)
