"""Broken environments: a point that walks on a line."""

from dataclasses import dataclass
from itertools import count
from typing import ClassVar

import gymnasium
import numpy as np

from . import mutant

Box = gymnasium.spaces.Box


class Walk(gymnasium.Env):
    """Ten steps."""

    observation_space = Box(-100.0, 100.0, (1,), np.float32)
    action_space = Box(-1.0, 1.0, (1,), np.float32)
    lasts = 10

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.at, self.steps = float(self.start(seed)), 0
        return self.observed(), {}

    def start(self, seed):
        return self.np_random.uniform(-1.0, 1.0)

    def step(self, action):
        self.at += float(np.sum(action))
        self.steps += 1
        return self.observed(), -abs(self.at), False, self.steps >= self.lasts, {"distance": abs(self.at)}

    def observed(self):
        return np.array([self.at], np.float32)


@dataclass(frozen=True)
class Sound:
    """Its env, its rewards and its measure."""

    lower_is_better: ClassVar[frozenset[str]] = frozenset({"distance"})

    def make(self):
        return Walk()

    def rewards(self, env):
        return {"own": "own", "near": lambda before, action, after, info: abs(env.unwrapped.at) < 1.0}

    def behaviour(self, env):
        return {"distance": "distance"}


def walks(sound=Sound, **changed):
    """With an env that differs in some attributes."""
    return mutant(sound, make=lambda self: mutant(Walk, **changed))


def pays(pay):
    """With another reward beside its own, of the env."""
    return mutant(Sound, rewards=lambda self, env: {"own": "own", "late": lambda *step: pay(env.unwrapped)})


def measures(measure):
    """With another measure."""
    return mutant(Sound, behaviour=lambda self, env: {"distance": measure})


class Farthest:
    """A measure with a memory: how far the walk has come in this episode."""

    def reset(self):
        self.farthest = 0.0

    def __call__(self, before, action, after, info):
        self.farthest = max(self.farthest, abs(float(after[0])))
        return self.farthest


def push(walk):
    """A reward that moves what it looks at."""
    walk.at += 0.1
    return 0.0


def of_chance(self, seed):
    """Where no seed is given."""
    return self.np_random.uniform(-1.0, 1.0) if seed is not None else np.random.default_rng().uniform(-1.0, 1.0)


GOALS = {
    "observation_space": gymnasium.spaces.Dict(
        dict.fromkeys(("achieved_goal", "desired_goal"), Walk.observation_space)
    ),
    "observed": lambda self: {"achieved_goal": Walk.observed(self), "desired_goal": np.ones(1, np.float32)},
}


def to_goal(before, action, after, info):
    """The reward of a walk to 1."""
    return -abs(float(after["achieved_goal"][0]) - 1.0)


class WithGoals(Sound):
    """The walk has a goal: to come to 1."""

    def make(self):
        return mutant(Walk, **GOALS)

    def rewards(self, env):
        return {"near": to_goal}

    def goal_rewards(self, env):
        return {"near": lambda achieved, desired: -np.abs(achieved - desired)[:, 0]}


def by_goals(pay, name="near"):
    """With another reward of goals, of an env, an achieved and a desired goal."""
    return mutant(WithGoals, goal_rewards=lambda self, env: {name: lambda *goals: pay(env.unwrapped, *goals)})


class Counts(Farthest):
    """A reward of goals that begins with each episode."""

    def __call__(self, *step):
        self.farthest += 1
        return to_goal(*step)


MADE = count()
SOUND = (
    Sound(),
    WithGoals(),
    mutant(
        Sound,
        rewards=lambda self, env: {"own": "own", "far": Farthest()},
        behaviour=lambda self, env: {"distance": Farthest()},
    ),
    mutant(WithGoals, rewards=lambda self, env: {"near": Counts()}),
)
MUTANTS = {
    "out of its space": ("environment-api", walks(observation_space=Box(500.0, 600.0, (1,), np.float32))),
    "acts in a matrix": (
        "environment-spaces",
        walks(action_space=Box(-1.0, 1.0, (2, 2), np.float32)),
        "raised UsageError: its actions are Box(-1.0, 1.0, (2, 2), float32)",
    ),
    "names no measure": ("environment-names", mutant(Sound, lower_is_better=frozenset({"error"})), "'error'"),
    "names no reward": ("environment-names", mutant(Sound, baseline="sparse"), "'sparse'"),
    "names a number": (
        "environment-names",
        mutant(Sound, rewards=lambda self, env: {"own": "own", "half": 0.5}),
        "'half' is 0.5",
    ),
    "says of a number nothing": (
        "environment-directions",
        mutant(Sound, lower_is_better=frozenset()),
        "nobody says whether less or more is better",
    ),
    "pays nothing known": (
        "environment-finite",
        pays(lambda walk: np.inf if walk.steps == 5 else 0.0),
        "after step 5 of an episode: it is inf",
    ),
    "tells nothing": ("environment-finite", measures("far"), "reads a key that info does not have"),
    "tells a row": (
        "environment-finite",
        measures(lambda before, action, after, info: np.abs(after)),
        "an array of shape (1,)",
    ),
    "loses the numbers in time": (
        "environment-finite",
        mutant(
            Sound,
            make=lambda self: mutant(Walk, lasts=150),
            behaviour=lambda self, env: {"distance": lambda *_: np.nan if env.unwrapped.steps == 120 else 0.0},
        ),
        "after step 120 of an episode: it is nan",
    ),
    "is seeded for one episode": (
        "environment-seeded",
        walks(lasts=500, start=of_chance),
        "an env that is reset with the same seed",
    ),
    "is unseeded": (
        "environment-seeded",
        mutant(
            Sound,
            make=lambda self: mutant(
                Walk, begun=next(MADE) / 1e3, start=lambda walk, seed: walk.begun + Walk.start(walk, seed)
            ),
        ),
        "another env with the same seed",
    ),
    "meddles": ("environment-looks-on", pays(push)),
    "pays goals otherwise": (
        "environment-goals",
        by_goals(lambda _, to, goal: -((to - goal) ** 2)[:, 0]),
        "by its goals alone -24.619",
    ),
    "pays by where it stands": (
        "environment-goals",
        by_goals(lambda walk, to, _: np.full(len(to), -abs(walk.at - 1.0))),
        "by its goals alone -0.3",
    ),
    "pays one step alone": ("environment-goals", by_goals(lambda _, to, goal: -np.linalg.norm(to - goal)), "shape ()"),
    "names no reward of goals": (
        "environment-goals",
        by_goals(lambda _, to, goal: -np.abs(to - goal)[:, 0], "nearer"),
        "names ['nearer']",
    ),
    "shows no goals": (
        "environment-goals",
        mutant(Sound, goal_rewards=WithGoals.goal_rewards),
        "raised UsageError: observations have no",
    ),
    "never ends": ("environment-ends", walks(lasts=10**9, observation_space=Box(-np.inf, np.inf, (1,), np.float32))),
}
