"""Broken rewards."""

import time
from collections import deque
from itertools import count

import numpy as np

from harness.reward.forms import reward_class
from harness_plugins.kit.trainings import NegativeDistance

from . import mutant


def pays(pay):
    """A reward that pays otherwise."""
    return mutant(NegativeDistance, __call__=lambda self, carry, s: (carry, pay(s)))


def carries(begin, go):
    """A reward that carries something: of the first distance, then of each step."""
    return mutant(NegativeDistance, initial_carry=begin, __call__=go)


def xp(s):
    """The library of a step's arrays."""
    return s.distance.__array_namespace__()


def lost_at(when):
    """A reward that pays no number at one step."""
    return pays(lambda s: xp(s).where(s.step == when, s.distance * np.nan, -s.distance))


def raises(self, carry, s):
    """In the second half of an episode."""
    if float(np.asarray(carry).max()) >= 36:
        raise IndexError("no more entries")
    return carry + 1.0, -s.distance


class RemembersOnSelf(NegativeDistance):
    """The last distance is kept on the reward instead of in the carry."""

    def initial_carry(self, begin_distance):
        object.__setattr__(self, "last", begin_distance)
        return begin_distance

    def __call__(self, carry, s):
        last = self.last
        object.__setattr__(self, "last", s.distance)
        return s.distance, last - s.distance


def with_numpy(step):
    """A function of numpy on an array of it."""
    return np.exp(-step.distance)


def usual(step):
    """What people write: methods of arrays, and no numpy."""
    jerk = ((step.action - step.before.action) ** 2).sum(-1)
    return {"reach": -step.distance, "jerk": -0.1 * jerk, "low": -1.0 * step.ground, "high": step.qpos.max(axis=1)}


def with_total(step):
    """A total beside its terms."""
    terms = {"reach": -step.distance, "speed": -0.1 * (step.qvel**2).mean(-1)}
    return terms["reach"] + terms["speed"], terms


def of_seven_joints(step):
    """For an arm that has a seventh joint."""
    return -(step.qpos[:, 6] ** 2)


SAMPLES, WORDS = [], deque()
"""What the mutants keep; a list would have spare room for a word for a while."""
SOUND = (NegativeDistance(), *(reward_class(it)() for it in (usual, with_total, of_seven_joints)))
MUTANTS = {
    "no number at step 37": ("reward-finite", lost_at(37)),
    "no number at step 77": ("reward-finite", lost_at(77)),
    "the root of a loss": ("reward-finite", pays(lambda s: xp(s).sqrt(s.begin_distance - s.distance))),
    "raises in time": ("reward-finite", carries(lambda self, d: d * 0.0, raises), "raised IndexError: no more entries"),
    "what it adds up overflows": (
        "reward-long-run",
        carries(lambda self, d: d * 0.0 + 1.0, lambda self, carry, s: (carry * 2.0, -s.distance * carry)),
    ),
    "each step adds a column to the carry": (
        "reward-long-run",
        carries(
            lambda self, d: d[:, None],
            lambda self, carry, s: (xp(s).concat([carry, s.distance[:, None]], axis=1), -s.distance),
        ),
    ),
    "keeps every sample": ("reward-leak", pays(lambda s: SAMPLES.append(s) or -s.distance)),
    "keeps a word of every step": ("reward-leak", pays(lambda s: WORDS.append(True) or -s.distance)),
    "whole numbers": ("reward-shape", pays(lambda s: xp(s).where(s.delta_distance > 0.0, -1, 1))),
    "the sum over the envs": ("reward-shape", pays(lambda s: -xp(s).sum(s.distance, axis=0))),
    "a total that is no sum of the terms": (
        "reward-shape",
        pays(lambda s: (s.distance, {"reach": -s.distance})),
        "raised UsageError: The total 0.612088",
    ),
    "divides by nothing": (
        "reward-finite-edges",
        pays(lambda s: (s.previous_distance - s.distance) / s.previous_distance),
    ),
    "divides by the speed": ("reward-finite-edges", pays(lambda s: s.distance / (s.qvel**2).sum(-1))),
    "updates the best": (
        "reward-arguments",
        pays(lambda s: np.minimum(s.previous_best, s.distance, out=s.previous_best) * 0.0 - s.distance),
        "previous_best was changed",
    ),
    "changes the action before": (
        "reward-arguments",
        pays(lambda s: s.before.action.__imul__(0.5)[:, 0] * 0.0 - s.distance),
        "before.action was changed",
    ),
    "counts in its carry": (
        "reward-arguments",
        carries(lambda self, d: d * 0.0, lambda self, carry, s: (carry.__iadd__(1.0), -s.distance)),
        "the carry was changed in place",
    ),
    "pays less with every episode": (
        "reward-episodes",
        mutant(
            NegativeDistance,
            episodes=count(),
            initial_carry=lambda self, d: d * 0.0 + next(self.episodes),
            __call__=lambda self, carry, s: (carry, -s.distance - 1e-3 * carry),
        ),
    ),
    "noise": ("reward-episodes", pays(lambda s: s.distance * np.random.default_rng().normal())),
    "remembers on itself": ("reward-memory", RemembersOnSelf()),
    "one entry of the carry for all envs": (
        "reward-carry-shape",
        carries(
            lambda self, d: (d.__array_namespace__().zeros(1),), lambda self, carry, s: ((carry[0] + 1.0,), -s.distance)
        ),
    ),
    "compares envs": ("reward-batch-as-alone", pays(lambda s: xp(s).mean(s.distance) - s.distance)),
    "a term that is the mean of the batch": (
        "reward-batch-as-alone",
        pays(lambda s: {"shared": xp(s).mean(s.distance), "own": -xp(s).mean(s.distance) - s.distance}),
        "the term 'shared' of env 0",
    ),
    "numpy": (
        "reward-array-library",
        pays(lambda s: np.where(s.delta_distance > 0.0, -s.delta_distance, 0.0)),
        "numpy was asked to compute on an array of another library: use __array_namespace__()",
    ),
    "numpy on the action": (
        "reward-array-library",
        pays(lambda s: {"reach": -s.distance, "effort": -np.abs(s.action).sum(-1)}),
        "does not support ufuncs",
    ),
    "methods of numpy": (
        "reward-array-library",
        pays(lambda s: -s.distance.clip(0.0, 1.0)),
        "object has no attribute 'clip'",
    ),
    "names of numpy": (
        "reward-array-library",
        pays(lambda s: -xp(s).fmin(s.distance, s.begin_distance)),
        "'fmin' is not in the Python array API standard",
    ),
    "looks before it pays": (
        "reward-array-library",
        pays(lambda s: -s.distance if s.step[0] > 3 else -1.5 * s.distance),
        "the value decides which way the code goes: use where()",
    ),
    "numpy in a plain function": ("reward-numpy", reward_class(with_numpy)(), "raised"),
    "slow": ("reward-slow", pays(lambda s: time.sleep(0.001) or -s.distance), "a step is paid in "),
    "pays for the target": ("reward-no-event", pays(lambda s: xp(s).where(s.distance <= 0.05, 1.0, 0.0) - s.distance)),
    "a term that is a whole number": (
        "reward-terms-float",
        pays(lambda s: {"reach": -s.distance, "loss": xp(s).where(s.delta_distance > 0.0, -1, 0)}),
    ),
    "another term for six envs": (
        "reward-terms",
        pays(lambda s: {"six" if s.distance.shape[0] == 6 else "reach": -s.distance}),
    ),
    "a term at times": (
        "reward-terms",
        pays(lambda s: {"reach": -s.distance, **({"late": 0.0 * s.distance} if s.step[0] > 3 else {})}),
    ),
}
