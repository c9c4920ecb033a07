"""Every form of a reward says of a step what is right, in every way of starting episodes, for every space."""

import time
from itertools import pairwise
from typing import Any, NamedTuple

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import (
    Box,
    Dict,
    Discrete,
    Graph,
    GraphInstance,
    MultiBinary,
    MultiDiscrete,
    OneOf,
    Sequence,
    Text,
    Tuple,
)
from gymnasium.vector import SyncVectorEnv
from gymnasium.vector.utils import iterate

from harness.record import read_recording
from tests.recorder.conftest import MODES, recorder, take

LENGTHS = (3, 2)
BOX = Box(-99, 99, (2,), np.float32)


def pair(count):
    """An array that tells of a count."""
    return np.array([count, 0.5], np.float32)


SPACES = {
    "box": (BOX, pair),
    "discrete": (Discrete(9), int),
    "several": (Tuple([MultiDiscrete([9, 9]), MultiBinary(2)]), lambda k: (np.array([k, 1]), np.int8([k % 2, 1]))),
    "dict": (Dict({"a": BOX, "b": Dict({"c": Discrete(9)})}), lambda k: {"a": pair(k), "b": {"c": k}}),
    "text": (Dict({"a": BOX, "t": Text(10)}), lambda k: {"a": pair(k), "t": "t" * (1 + k)}),
    "sequence": (Sequence(BOX), lambda k: (pair(k),) * (1 + k % 3)),
    "graph": (Graph(BOX, None), lambda k: GraphInstance(np.full((1 + k % 2, 2), k, np.float32), None, None)),
    "one of": (OneOf([BOX, Text(10)]), lambda k: (np.int64(0), pair(k)) if k % 2 else (np.int64(1), "t" * (1 + k))),
}  # fmt: skip
"""Of observations, and what is observed after so many steps of an episode."""


def look(seen):
    """A number that tells what was seen."""
    if isinstance(seen, str):
        return float(len(seen))
    if isinstance(seen, dict):
        return look(tuple(seen.values()))
    if isinstance(seen, tuple):
        return sum((place + 1) * look(part) for place, part in enumerate(seen) if part is not None)
    return float(np.sum(seen))


class Line(gymnasium.Env[Any, Any]):
    """Counts its steps. Its first start differs from its later ones, and so does what it tells of them."""

    action_space = Box(-1, 1, (1,), np.float32)

    def __init__(self, space, length):
        self.observation_space, self._see = SPACES[space]
        self.length, self.count, self.starts = length, 0, 0

    def reset(self, *, seed=None, options=None):
        """Begin."""
        super().reset(seed=seed)
        self.count, self.starts = 0, self.starts + 1
        return self._see(0), {"x": -1.0 * self.starts, "deep": {"x": -2.0 * self.starts}, "begun": True}

    def step(self, action):
        """Count on; `goal` is told at an episode's end alone."""
        self.count += 1
        ends = self.count == self.length
        info = {"x": float(self.count), "deep": {"x": 0.5 * self.count, **({"goal": 9.0} if ends else {})}}
        info |= {"goal": 4.0} if ends else {"on": 1.0}
        return self._see(self.count), float(self.count), ends and self.length == 3, ends and self.length == 2, info


class Step(NamedTuple):
    """What a step was, as an env alone tells it."""

    before: Any
    action: float
    after: Any
    info: Any
    acted: float
    told: Any
    columns: dict[str, float]


def walked(space, length, actions):
    """The steps of one env alone that takes these actions."""
    env, steps, seen, told, acted = Line(space, length), [], None, None, 0.0
    for action in actions:
        if seen is None:
            (seen, told), acted = env.reset(), 0.0
        after, pay, terminated, truncated, info = env.step(action)
        place = {"episode": env.starts - 1, "step": env.count - 1, "terminated": terminated, "truncated": truncated}
        steps.append(Step(seen, action, after, info, acted, told, {**place, "reward/own": pay}))
        seen, told, acted = (None, None, None) if terminated or truncated else (after, info, action)
    return steps


class Sum:
    """Remembers."""

    def reset(self):
        """Begin."""
        self.sum = 0.0

    def __call__(self, step):
        """The sum of what is told in an episode."""
        self.sum += step.info["x"] + 10 * look(step.before.observation)
        return self.sum


def _goal(info):
    return 10 * info.get("goal", 0.0) + info["deep"].get("goal", 0.0)


def forms(space):
    """By name: how a reward is given, or none for one of its terms, and what it is to say of a `Step`."""
    several = SyncVectorEnv([lambda: Line(space, 1)] * len(LENGTHS)).observation_space

    def each(batch):
        return np.array([look(one) for one in iterate(several, batch)])

    def goals(info):
        none = np.zeros(len(LENGTHS))
        deep = np.where(info["deep"].get("_goal", False), info["deep"].get("goal", 0.0), 0.0)
        return 10 * np.where(info.get("_goal", False), info.get("goal", none), 0.0) + deep

    def seen(it):
        return look(it.before) + 10 * it.action + 100 * look(it.after)

    def before(it):
        return look(it.before) + 10 * it.acted + 100 * it.told["x"] + 1000 * it.told["deep"]["x"]

    def before_all(step):
        told = 100 * step.before.info["x"] + 1000 * step.before.info["deep"]["x"]
        return each(step.before.observation) + 10 * step.before.action[:, 0] + told

    def stepped(step):
        return look(step.before.observation) + 10 * float(step.action[0]) + 100 * look(step.observation)

    def before_one(step):
        return before(Step(step.before.observation, 0, 0, {}, float(step.before.action[0]), step.before.info, {}))

    def told(it):
        return it.info["x"] + _goal(it.info)

    def deep(it):
        return it.info["deep"]["x"]

    def ends(it):
        return it.columns["terminated"] + 2 * it.columns["truncated"]

    class SumOfAll:
        def reset(self, mask):
            self.sums = np.where(mask, 0.0, getattr(self, "sums", 0.0))

        def __call__(self, step):
            self.sums = self.sums + step.info["x"] + 10 * each(step.before.observation)
            return self.sums

    return {
        "four": (lambda o, a, n, i: look(o) + 10 * float(a[0]) + 100 * look(n), seen),
        "step": (stepped, seen),
        "before": (before_one, before),
        "info": (lambda o, a, n, i: i["x"] + _goal(i), told),
        "keys": (
            lambda step: ("begun" in step.before.info) + 2 * ("on" in step.info),
            lambda it: ("begun" in it.told) + 2 * ("on" in it.info),
        ),
        "watched": (lambda o, a, n, i: i["deep"]["x"] + 0 * time.monotonic(), deep),
        "computed": (lambda o, a, n, i: 2.0 * i["x"] + 1.0, lambda it: 2.0 * it.info["x"] + 1.0),
        "key": ("x", lambda it: it.info["x"]),
        "deep key": ("deep.x", deep),
        "named": ({"a": "x", "b": lambda step: _goal(step.info)}, told),
        "terms": (
            lambda step: {"a": look(step.observation), "b": step.info["deep"]["x"]},
            lambda it: look(it.after) + deep(it),
        ),
        "terms/a": (None, lambda it: look(it.after)),
        "terms/b": (None, deep),
        "memory": (Sum(), None),
        "named memory": ({"a": Sum(), "b": lambda o, a, n, i: 0.0}, None),
        "all memory": (SumOfAll(), None),
        "all terms": (
            lambda step: {"a": each(step.observation), "b": step.info["x"]},
            lambda it: look(it.after) + it.info["x"],
        ),
        "all terms/a": (None, lambda it: look(it.after)),
        "all terms/b": (None, lambda it: it.info["x"]),
        "all": (lambda o, a, n, i: each(o) + 10 * a[:, 0] + 100 * each(n), seen),
        "all of step": (
            lambda step: each(step.observation) + step.info["x"] + goals(step.info),
            lambda it: look(it.after) + told(it),
        ),
        "all before": (before_all, before),
        "ends": (lambda step: step.terminated + 2 * step.truncated, ends),
        "all ends": (lambda step: step.terminated + 2 * step.truncated, ends),
    }


def _summed(steps):
    sums = []
    for it in steps:
        begins = "begun" in it.told
        sums.append((0.0 if begins else sums[-1]) + it.info["x"] + 10 * look(it.before))
    return sums


@pytest.mark.parametrize("count", [18, 115])
@pytest.mark.parametrize("mode", MODES, ids=lambda mode: mode.name if mode else "one env")
@pytest.mark.parametrize("space", SPACES)
def test_every_form_says_what_one_env_alone_tells(space, mode, count, tmp_path):
    """Of the first steps and of later ones, of the last step of an episode and of the first one."""
    asked = {name: it for name, it in forms(space).items() if mode or not name.startswith("all")}
    given = {name: it for name, (it, _) in asked.items() if it}
    kept = {"lower_is_better": ["end"], "behaviour": {"end": "goal"}, "bounds": {"end": (0.0, 10.0)}}
    batched = {"batched": [name for name in given if name.startswith("all")]} if mode else {}
    actions = np.linspace(-1, 1, 2 * count, dtype=np.float32).reshape(count, 2, 1)
    env = recorder(
        [lambda length=length: Line(space, length) for length in LENGTHS],
        mode,
        tmp_path,
        rewards=given,
        **kept,
        **batched,
    )
    stepped = take(env, actions if mode else actions[:, 0], mode)
    found = read_recording(tmp_path)
    facts = found.facts
    assert (facts.failures, facts.notes, facts.bounds, facts.seed) == ((), (), kept["bounds"], 0)
    assert facts.num_envs == len(stepped[0])
    for env, ticks in enumerate(map(np.flatnonzero, stepped.T)):
        steps, rows = walked(space, LENGTHS[env], actions[ticks, env, 0].tolist()), found["env"] == env
        assert np.array_equal(found["tick"][rows], ticks)
        for name in steps[0].columns:
            assert np.array_equal(found[name][rows], [it.columns[name] for it in steps]), name
        for name, (_, right) in asked.items():
            expected = _summed(steps) if right is None else [right(it) for it in steps]
            np.testing.assert_allclose(found[f"reward/{name}"][rows], expected, rtol=1e-6, err_msg=name)
        ends = [it.info.get("goal", np.nan) for it in steps]
        assert np.array_equal(found["behaviour/end"][rows], ends, equal_nan=True)
        assert all(it.told == last.info for last, it in pairwise(steps) if "begun" not in it.told)
