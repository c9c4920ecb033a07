"""What functions say that are asked late is what they say at once, and the steps say so too."""

import random

import gymnasium
import numpy as np
import pytest

from harness.record import read_recording
from harness.recorder.column import Column
from harness.recorder.computing import bound, may_wait, only_computes
from harness.recorder.taken import ROWS_AT_ONCE
from tests.recorder.conftest import MODES, recorder, take

REWARDS, TOGETHER, STEPS = 500, 50, 450
WEIGHT, OTHER = 0.5, (0.25, 2.0)
LEAVES = (
    *("float(n[0])", "float(o[1])", "float(n[k % 3])", "float(a)", "float(i['x'])", "i.get('end', 0.0)", "WEIGHT"),
    *("OTHER[1]", "float(np.sum(n))", "float(np.abs(o).max())", "math.tanh(float(n[2]))", "half(float(n[1]))"),
    *("sum(float(x) for x in o)", "max(map(float, n))", "len(i) / 3", "-0.1"),
)
STEP_LEAVES = (
    *("float(step.before.action)", "float(step.before.observation[0])", "step.before.info['x']"),
    *("float(step.action)", "float(step.observation[2])", "step.info['x']", "WEIGHT", "half(1.0)"),
)


def half(value):
    """A function that others call."""
    return WEIGHT * value


def expression(draw, leaves, depth=3):
    """The code of a number."""
    if depth == 0 or draw.random() < 0.2:
        return draw.choice(leaves)
    one, other = (expression(draw, leaves, depth - 1) for _ in range(2))
    sign = draw.choice("+-*")
    return draw.choice((f"({one} {sign} {other})", f"({one} if {other} > 0.1 else {other})", f"abs({one})"))


def drawn(number):
    """A reward of one of the forms, as somebody may write it."""
    draw = random.Random(number)
    is_step = draw.random() < 0.4
    code = expression(draw, STEP_LEAVES if is_step else LEAVES)
    returned = draw.choice(("total", "total", "{'a': total, 'b': 2.0 * total}"))
    lines = [
        f"def reward({'step' if is_step else 'o, a, n, i'}):", "    k, total = 0, 0.0",
        f"    for k in range({draw.choice((1, 2, 3))}):",
        f"        total += {code}", f"    return {returned}",
    ]  # fmt: skip
    known = {"np": np, "math": __import__("math"), "half": half, "WEIGHT": WEIGHT, "OTHER": OTHER}
    exec("\n".join(lines), known)
    return known["reward"]


class Walk(gymnasium.Env):
    """Its observations and what it tells change in every step, and it ends now and then."""

    observation_space = gymnasium.spaces.Box(-9, 9, (3,), np.float32)
    action_space = gymnasium.spaces.Discrete(3)

    def reset(self, *, seed=None, options=None):
        """Begin somewhere."""
        super().reset(seed=seed)
        self.seen = self.np_random.normal(size=3).astype(np.float32)  # the same array, which is written into
        return self.seen, {"x": -1.0}

    def step(self, action):
        """Go on."""
        self.seen += self.np_random.normal(size=3).astype(np.float32) * 0.1 + 0.01 * float(action)
        ends = bool(self.np_random.random() < 0.05)
        info = {"x": float(self.seen[0]), **({"end": 3.0} if ends else {})}
        return self.seen, float(self.seen[1]), ends, False, info


def record(rewards, path, mode):
    """All columns, of one env or of a batch."""
    env = recorder([Walk] * 2, mode, path, rewards=rewards)
    env.action_space.seed(0)
    take(env, [env.action_space.sample() for _ in range(STEPS)], mode)
    found = read_recording(path)
    return found.facts.failures, {name: np.asarray(found[name]) for name in found.names}


@pytest.mark.parametrize(
    "first", [pytest.param(it, marks=[pytest.mark.slow] * (it > TOGETHER)) for it in range(0, REWARDS, TOGETHER)]
)
def test_late_is_what_it_is_at_once(first, tmp_path, monkeypatch):
    """Of 500 rewards, the first hundred at every run, in all ways of starting episodes."""
    rewards = {str(number): drawn(number) for number in range(first, first + TOGETHER)}
    assert all(map(only_computes, rewards.values()))
    assert all(map(may_wait, rewards.values()))
    mode = MODES[first // TOGETHER % len(MODES)]
    failed, late = record(rewards, tmp_path / "late", mode)
    monkeypatch.setattr(Column, "waits", property(lambda self: False, lambda self, value: None), raising=False)
    failed_at_once, at_once = record(rewards, tmp_path / "at once", mode)
    assert failed == failed_at_once == ()
    assert late.keys() == at_once.keys()
    for name, values in late.items():
        assert np.array_equal(values, at_once[name], equal_nan=True), name


SCALE = 1.0


def scaled(observation, action, next_observation, info):
    """Reads a number by a name of the module."""
    return SCALE * float(next_observation[0])


def test_function_whose_names_are_given_other_values_is_given_up(counting, record, tmp_path, monkeypatch):
    """Two rewards would stand under one name."""
    env = record(counting(10**6), rewards={"scaled": scaled})
    env.reset(seed=0)
    action = np.zeros(1, np.float32)
    for _ in range(200):
        env.step(action)
    monkeypatch.setitem(globals(), "SCALE", 2.0)
    with pytest.warns(UserWarning, match="'scaled' failed .* a name that it reads was given another value"):  # noqa: PT031
        for _ in range(ROWS_AT_ONCE):
            env.step(action)
    env.close()
    found = read_recording(tmp_path / "run")["reward/scaled"]
    right = np.arange(1.0, len(found) + 1)
    assert np.array_equal(found[~np.isnan(found)], right[~np.isnan(found)])


def prints(observation, action, next_observation, info):
    """Says it at once."""
    print(info)  # noqa: T201
    return 0.0


def with_array(weights):
    """Somebody may write into them later."""
    return lambda observation, action, next_observation, info: float(weights[0])


@pytest.mark.parametrize("function", [prints, with_array(np.ones(1)), with_array((np.ones(1),)), with_array([1.0])])
def test_what_may_say_otherwise_later_does_not_wait(function):
    """Others may write into what it reads, or see what it does."""
    assert not (only_computes(function) and may_wait(function))
    assert SCALE in bound([scaled])
