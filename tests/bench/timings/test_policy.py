"""How long a policy thinks."""

from functools import partial

import numpy as np
import pytest
from numpy.random import default_rng

from harness.policy import Deterministic, Gaussian, Greedy, SquashedGaussian

pytestmark = pytest.mark.bench
SEEN, WIDTH, ACTIONS = 28, 64, 6


def _policy(kind, activation, is_normalised):
    """64x64, with the observations and actions of the FD100."""
    rng = default_rng(0)
    shapes = {"hidden.0": (WIDTH, SEEN), "hidden.1": (WIDTH, WIDTH), **dict.fromkeys(kind.heads, (ACTIONS, WIDTH))}
    weights = {f"{layer}.weight": 0.2 * rng.normal(size=shape) for layer, shape in shapes.items()}
    weights |= {f"{layer}.bias": rng.normal(size=out) for layer, (out, _) in shapes.items()}
    if is_normalised:
        weights |= {"observation.mean": rng.normal(size=SEEN), "observation.std": np.ones(SEEN)}
    arrays = {name: array.astype(np.float32) for name, array in weights.items()}
    actions = (ACTIONS,) if kind is Greedy else ((-1.0,) * ACTIONS, (1.0,) * ACTIONS)
    return kind(arrays, activation, *actions)


def _layer(policy, name):
    """Weight, (into, out), and bias, (out,)."""
    return np.ascontiguousarray(policy.weights[f"{name}.weight"].T), policy.weights[f"{name}.bias"]


@pytest.mark.parametrize("kind", [SquashedGaussian, Gaussian, Deterministic, Greedy])
@pytest.mark.parametrize("activation", ["relu", "tanh"])
@pytest.mark.parametrize("is_normalised", [False, True])
def test_policy_beside_its_layers_alone(require_speed, amount, kind, activation, is_normalised):
    """One observation through 64x64 takes at most 2.5 times as long as its three layers, written out in numpy.

    The rest is the scaling of the observation, the box of the actions, and calls of Python. 1.1 to 2 times as long was
    measured, 11 to 17 us.
    """
    policy, seen, calls = _policy(kind, activation, is_normalised), np.ones((1, SEEN), np.float32), amount(5_000, 2)
    first, second, last = (_layer(policy, name) for name in ("hidden.0", "hidden.1", kind.heads[0]))
    activate = np.tanh if activation == "tanh" else partial(np.maximum, np.zeros((), np.float32))

    def bare():
        for _ in range(calls):
            values = activate(seen @ first[0] + first[1])
            values = activate(values @ second[0] + second[1])
            values = values @ last[0] + last[1]
        assert values.shape == (1, ACTIONS)

    def act():
        for _ in range(calls):
            actions = policy.act(seen)
        assert actions.shape == ((1,) if kind is Greedy else (1, ACTIONS))

    require_speed(bare, act, at_least=0.36, rounds=5)
