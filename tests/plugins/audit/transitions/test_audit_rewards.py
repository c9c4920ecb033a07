"""`audit_rewards` in a small env whose next state is drawn anew in every step."""

import re

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box, Discrete
from numpy.random import default_rng

from harness_plugins.audit import audit_rewards
from tests.refusals import refused

TABLE = default_rng(0).normal(size=(2, 3, 2, 3))
"""Of two rewards, by state, action and next state."""


class Anywhere(gymnasium.Env):
    """Three states, two actions; whatever is done, any state follows."""

    observation_space = Discrete(3)
    action_space = Discrete(2)

    def __init__(self):
        self.closed, self.state, self.left = False, 0, 0

    def reset(self, **options):
        """Any state."""
        super().reset(**options)
        self.state, self.left = int(self.np_random.integers(3)), 20
        return self.state, {}

    def step(self, action):
        """Pays the action; ends after 20 steps."""
        self.state, self.left = int(self.np_random.integers(3)), self.left - 1
        return self.state, float(action), self.left == 0, False, {"left": self.left}

    def close(self):
        """Keeps that it was called."""
        self.closed = True


def first(state, action, following, info):
    """By the table."""
    return float(TABLE[0, state, action, following])


def second(state, action, following, info):
    """The same."""
    return float(TABLE[1, state, action, following])


def shaped(state, action, following, info):
    """Twice `first`, with potential shaping."""
    return 2.0 * first(state, action, following, info) + 0.9 * following**2 - state**2 + 1.0


class Counting:
    """Has a memory that nobody is told of."""

    count = 0

    def __call__(self, state, action, following, info):
        """How often it was called."""
        self.count += 1
        return float(self.count)


class Remembering(Counting):
    """Says that it has one."""

    def reset(self):
        """Begins again."""
        self.count = 0


def audit(rewards, **given):
    """With few episodes."""
    return audit_rewards(Anywhere, rewards, **{"gamma": 0.9, "episodes": 4, **given})


def pair_of(found, one, other):
    """Of these two."""
    return next(it for it in found.pairs if (it.one, it.other) == (one, other))


@pytest.fixture(scope="module")
def found():
    """Three rewards, and one policy beside random actions."""
    rewards = {"first": first, "second": second, "shaped": shaped}
    return audit(rewards, policies={"one": lambda observation: 1}, episodes=10)


def test_epic_comes_near_its_exact_value(found):
    """All transitions are met: random actions and `one` take action 1 three times in four."""
    weight = np.array([0.25, 0.75])
    forms = []
    for values in TABLE:
        mean = np.einsum("a,sat->s", weight, values) / 3
        forms.append(values + 0.9 * mean[None, None, :] - mean[:, None, None])
    weights = np.broadcast_to(weight[None, :, None], (3, 2, 3)).ravel()
    covariance = np.cov(*(form.ravel() for form in forms), aweights=weights)
    exact = np.sqrt((1.0 - covariance[0, 1] / np.sqrt(covariance[0, 0] * covariance[1, 1])) / 2.0)
    mean = pair_of(found, "first", "second").forms["EPIC"]
    assert mean.value == pytest.approx(exact, abs=0.05)
    assert (mean.seeds, mean.low < mean.value < mean.high) == (5, True)


def test_shaping_is_a_distance_in_steps_alone(found):
    """EPIC, DARD and STARC see through it."""
    it = pair_of(found, "first", "shaped")
    assert {form: mean.value for form, mean in it.forms.items()} == pytest.approx(
        {"EPIC": 0.0, "DARD": 0.0, "STARC": 0.0}, abs=1e-6
    )
    assert it.steps.value > 0.1


def test_what_policies_earn_is_told(found):
    """`one` earns an env payment of 1 in each of 20 steps, random actions half of it."""
    random, one = found.earned
    assert (random.behaviour, one.behaviour, one.episodes) == ("random actions", "one", 50)
    assert one.returns["own"].value == 20.0
    assert random.returns["own"].value == pytest.approx(10.0, abs=1.5)
    assert random.returns["own"].low < random.returns["own"].value < random.returns["own"].high


def test_what_was_measured_is_said(found):
    """Table and data."""
    text = " ".join(str(found).split())
    assert "Measured 5 times in the transitions of random actions, one, each time with 10 new episodes" in text
    assert "first and shaped" in text
    assert found.to_json()["steps"] == 5 * 2 * 10 * 20


def test_same_seed_gives_the_same():
    """Another gives other episodes."""
    one, again, other = (audit({"first": first, "second": second}, seed=seed).to_json() for seed in (1, 1, 2))
    assert one == again
    assert one != other


def test_hidden_memory_is_refused():
    """What it pays says nothing: its name, and what to write instead."""
    with refused(r"reward 'odd' failed .* Write a class with reset\(\)"):
        audit({"first": first, "odd": Counting()}, episodes=1, steps=6)


TAKEN = ", which only a step that was taken has"
BROKEN = "asked about another step than the one taken, it fails: ZeroDivisionError: float division by zero"


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ("own", f"it is what the env pays{TAKEN}"),
        ("left", f"it is info key 'left'{TAKEN}"),
        (lambda s, a, n, info: float(info["left"]), f"it reads info{TAKEN}"),
        (lambda s, a, n, info: float(info.get("left", 0)), f"it reads info{TAKEN}"),
        (lambda s, a, n, info: float({**info}["left"]), f"it reads info{TAKEN}"),
        (Remembering(), "it has a memory, so that what it pays depends on more than one transition"),
        (
            lambda s, a, n, info: float(s) / len(dict.keys(info)),
            "asked about another step than the one taken, it fails: ZeroDivisionError: float division by zero",
        ),
        (lambda step: float(step.info["left"]), f"it reads info{TAKEN}"),
        (lambda step: float(step.before.action), f"it reads before.action{TAKEN}"),
    ],
)
def test_reward_that_is_no_function_of_a_transition_is_compared_in_steps_alone(given, told):
    """The reason is said, and every other pair has its distances."""
    found = audit({"first": first, "odd": given, "second": second}, episodes=1, steps=6)
    odd = pair_of(found, "first", "odd")
    assert all(mean.value is None for mean in odd.forms.values())
    assert set(odd.reasons.values()) == {f"odd: {told}"}
    assert odd.steps.value is not None
    assert pair_of(found, "first", "second").reasons == {}
    assert told in " ".join(str(found).split())


def test_reward_that_fails_for_steps_to_anywhere_has_no_epic():
    """DARD and STARC ask it about steps near in time, some of which it does not know either."""

    def near_only(state, action, following, info):
        if isinstance(state, np.ndarray) and abs(following - state)[0] > 2.5:
            raise ValueError("too far")
        return float(following[0])

    class Line(Anywhere):
        observation_space = Box(-np.inf, np.inf, (1,), np.float64)

        def reset(self, **options):
            super().reset(**options)
            self.place = np.zeros(1)
            return self.place.copy(), {}

        def step(self, action):
            _, paid, ended, cut, info = super().step(action)
            self.place += 0.2 + 0.1 * action
            return self.place.copy(), paid, ended, cut, info

    (it,) = audit_rewards(Line, {"near": near_only}, episodes=1).pairs
    assert set(it.reasons) == {"EPIC", "DARD", "STARC"}
    assert it.reasons["EPIC"] == "near: asked about another step than the one taken, it fails: ValueError: too far"
    assert it.reasons["DARD"].startswith("own: ")


def test_env_that_was_given_stays_open():
    """One that was made here is closed."""
    made, envs = Anywhere(), []

    def make():
        envs.append(Anywhere())
        return envs[-1]

    audit_rewards(made, {"first": first}, episodes=1)
    audit_rewards(make, {"first": first}, episodes=1)
    assert (made.closed, envs[0].closed) == (False, True)


def test_long_episodes_are_cut():
    """Also where the env never ends them."""
    assert audit({"first": first}, episodes=1, steps=3).facts["steps"] == 5 * 3


def fails(state, action, following, info):
    """In every step."""
    raise ValueError("no")


@pytest.mark.parametrize(
    ("env", "rewards", "given", "told"),
    [
        (Anywhere, {}, {}, "name at least one reward"),
        (Anywhere, {"first": first}, {"gamma": 1.0}, "gamma=1: must be above 0 and below 1"),
        (Anywhere, {"first": first}, {"gamma": float("nan")}, "gamma=nan"),
        (Anywhere, {"first": first}, {"episodes": 0}, "episodes=0: must be at least 1"),
        (Anywhere, {"first": first}, {"seed": -1}, "seed=-1"),
        (Anywhere, {"first": first}, {"policies": {"p": 3}}, "'p' is 3: give a function"),
        (Anywhere, {"first": 3}, {}, "reward 'first' is 3"),
        (Anywhere, {"first": lambda state: 0.0}, {}, "it has to take"),
        (Anywhere, {"a": "own", "b": "own"}, {}, "'a' and 'b' are both what the env pays: leave one out"),
        (Anywhere, {"first": fails}, {}, "reward 'first' failed in env 0, episode 0, step 0: ValueError: no"),
        (Anywhere, {"first": "no_such"}, {}, "info has no 'no_such'"),
        ("NoSuchEnv-v0", {"first": first}, {}, "cannot be made"),
        (3, {"first": first}, {}, "env is int: give one gymnasium.Env"),
    ],
)
def test_what_cannot_be_used_is_one_line(env, rewards, given, told):
    """It says what was given and what is allowed."""
    with refused(re.escape(told)):
        audit_rewards(env, rewards, **given)


def test_a_reward_that_is_another_but_for_its_scale_is_told():
    """In the steps that were taken; one with shaping by a potential is another reward there."""
    found = audit({"first": first, "double": lambda *step: 2.0 * first(*step) - 1.0, "shaped": shaped}, episodes=2)
    rescaled = {(it.other, it.one): it.rescaling for it in found.pairs if it.rescaling}
    assert [*rescaled] == [("double", "first")]
    assert rescaled["double", "first"].steps == found.facts["steps"]
    told = "double is 2 x first - 1, in all 200 steps, for which first paid 17 different numbers."
    assert told in " ".join(str(found).split())


def test_functions_of_a_step_are_asked_as_those_of_four_arguments():
    """They are the same rewards, and terms are summed."""

    def of_step(step):
        return {"half": 0.5 * first(step.before.observation, step.action, step.observation, {}), "rest": 0.0}

    pair = pair_of(audit({"first": first, "half": of_step}), "first", "half")
    assert all(it.value == pytest.approx(0.0, abs=1e-6) for it in pair.forms.values())
