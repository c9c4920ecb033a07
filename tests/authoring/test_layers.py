"""Layers of any library as the weights of a policy."""

import re

import numpy as np
import pytest
from numpy.random import default_rng
from numpy.testing import assert_allclose

from harness.policy import Deterministic, layer_weights
from tests.refusals import refused

RNG = default_rng(0)


def _layer(inputs, outputs):
    return RNG.normal(size=(outputs, inputs)), RNG.normal(size=outputs)


def test_a_policy_of_layers_does_what_the_layers_do():
    """A tanh between them, and at the end into the box."""
    (first, offset), (last, shift) = hidden, mean = _layer(5, 4), _layer(4, 2)
    policy = Deterministic(layer_weights([hidden], mean=mean), "tanh", (-2.0, -2.0), (2.0, 2.0))
    observation = RNG.normal(size=(3, 5)).astype(np.float32)
    expected = 2.0 * np.tanh(np.tanh(observation @ first.T + offset) @ last.T + shift)
    assert_allclose(policy.act(observation), expected, rtol=1e-5)


def test_arrays_are_copies_in_single_precision():
    """What trains on does not change the policy."""
    weight, bias = np.ones((2, 3), np.float32), np.zeros(2, np.float32)
    weights = layer_weights([], mean=(weight, bias))
    weight[:] = 7.0
    assert {name: array.dtype for name, array in weights.items()} == dict.fromkeys(
        ("mean.weight", "mean.bias"), np.dtype(np.float32)
    )
    assert weights["mean.weight"].max() == 1.0


@pytest.mark.parametrize(
    ("hidden", "head", "told"),
    [
        ([_layer(5, 4), _layer(3, 4)], _layer(4, 2), "layer hidden.1: weight (4, 3) and bias (4,); allowed: (out, 4)"),
        ([_layer(5, 4)], _layer(5, 2), "layer mean: weight (2, 5) and bias (2,); allowed: (out, 4)"),
        ([(np.zeros((5, 4)), np.zeros(4))], _layer(4, 2), "layer hidden.0: weight (5, 4) and bias (4,)"),
        ([(np.zeros(4), np.zeros(4))], _layer(4, 2), "layer hidden.0: weight (4,)"),
    ],
)
def test_layers_that_do_not_fit_are_named(hidden, head, told):
    """With both shapes, and with what to do: libraries differ in how they keep a weight."""
    with refused(re.escape(told)) as error:
        layer_weights(hidden, mean=head)
    assert "Transpose the weight" in str(error.value)
