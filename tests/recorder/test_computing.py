"""Which functions need no watching, by their code; where it is not clear they are watched."""

import math
import random

import numpy as np
import pytest
from numpy import exp
from numpy.random import rand

from harness.recorder.computing import only_computes

GOAL, GAINS = np.zeros(2), (1.0, 0.5)
HOLDER = [random]


def _helper(x):
    return float(np.clip(x, -1, 1)) * GAINS[0]


def _draws(x):
    return x * random.random()


def _loops(x):
    while x:
        pass
    return x


def _stores(x):
    global GAINS  # noqa: PLW0603 (what is tested)
    GAINS = (x, x)
    return x


def _imports(x):
    import random as chance

    return x * chance.random()


PLAIN = [
    lambda s, a, n, i: float(n[0] - 0.1 * abs(n[2])),
    lambda s, a, n, i: -math.hypot(*(n[:2] - GOAL)) + exp(i["x"]) + np.linalg.norm(a),
    lambda s, a, n, i: _helper(n[0]) if i.get("ok", False) else max(GAINS),
]
WATCHED = [
    lambda s, a, n, i: np.random.rand(),
    lambda s, a, n, i: random.random() if s[0] > 1_000 else 0.0,
    lambda s, a, n, i: rand(),
    lambda s, a, n, i: _draws(n[0]),
    lambda s, a, n, i: _loops(n[0]),
    lambda s, a, n, i: _stores(n[0]),
    lambda s, a, n, i: _imports(n[0]),
    lambda s, a, n, i: getattr(np, "ran" + "dom").rand(),
    lambda s, a, n, i: HOLDER[0].random(),
    lambda s, a, n, i, draw=random.random: draw(),
    lambda s, a, n, i: eval("1.0"),
    lambda s, a, n, i: n.__class__(1),
    random.random,
]


@pytest.mark.parametrize("function", PLAIN)
def test_function_that_only_computes(function):
    """With helpers, constants, mathematics."""
    assert only_computes(function)


def test_function_that_might_draw_or_never_return(subtests):
    """By a name, a helper, an import, an argument, an object."""
    for function in WATCHED:
        with subtests.test(function=function):
            assert not only_computes(function)


def test_closure_is_looked_into():
    """What a function was made with."""

    def made(held):
        return lambda s, a, n, i: held(n[0])

    assert only_computes(made(math.sin))
    assert not only_computes(made(random.uniform))
