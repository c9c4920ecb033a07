"""Forwards and backwards: what torch and its automatic differentiation say of the same weights."""

import numpy as np
import pytest
import torch
from hypothesis import given, settings, strategies as st
from numpy.random import default_rng
from numpy.testing import assert_allclose

from harness_plugins.fast_sac.network import (
    Room,
    backward,
    count_parameters,
    draw_weights,
    forward,
    networks_in,
)

SIZES = st.lists(st.integers(1, 7), min_size=3, max_size=5)


def drawn(count, sizes, rng):
    """Networks with first weights."""
    networks = networks_in(np.empty(count_parameters(count, sizes), np.float32), count, sizes)
    draw_weights(networks, rng)
    return networks


def inputs_of(rng, *shape):
    """Normal numbers, and ones behind them."""
    values = rng.standard_normal((*shape[:-1], shape[-1] + 1), dtype=np.float32)
    values[..., -1] = 1.0
    return values


def by_torch(networks, activation, inputs):
    """Weights and inputs as leaves of a graph, and what comes out of it, by torch's own linear layers."""
    weights = [torch.tensor(weight, requires_grad=True) for weight in networks]
    leaf = torch.tensor(inputs[..., :-1], requires_grad=True)
    outputs = []
    for network in range(len(networks[0])):
        values = leaf if leaf.ndim == 2 else leaf[network]
        for layer, weight in enumerate(weights):
            values = torch.nn.functional.linear(values, weight[network, :-1].T, weight[network, -1])
            values = values if layer == len(weights) - 1 else getattr(torch, activation)(values)
        outputs.append(values)
    return weights, leaf, torch.stack(outputs)


@pytest.mark.parametrize("activation", ["relu", "tanh"])
@given(SIZES, st.integers(1, 3), st.integers(1, 9), st.booleans(), st.integers(0, 2**32))
@settings(max_examples=25, deadline=None)
def test_both_ways_are_those_of_torch(activation, sizes, count, rows, shared, seed):
    """Outputs, the gradients of all weights, and that of the inputs, of any networks, to float32's rounding."""
    rng = default_rng(seed)
    networks, room = drawn(count, sizes, rng), Room.of(count, rows, sizes)
    inputs = inputs_of(rng, rows, sizes[0]) if shared else inputs_of(rng, count, rows, sizes[0])
    weights, leaf, expected = by_torch(networks, activation, inputs)
    output = forward(networks, activation, inputs, room)
    assert_allclose(output, expected.detach().numpy(), rtol=1e-4, atol=1e-5)
    error = rng.standard_normal(output.shape, dtype=np.float32)
    expected.backward(torch.tensor(error))
    room.error[-1][...] = error
    gradient = tuple(np.empty_like(weight) for weight in networks)
    first = backward(networks, inputs, room, gradient)
    for ours, theirs in zip(gradient, weights, strict=True):
        assert_allclose(ours, theirs.grad.numpy(), rtol=1e-4, atol=1e-5)
    by_input = np.matmul(first, networks[0][:, :-1].swapaxes(-1, -2))
    by_input = by_input.sum(axis=0) if shared else by_input
    assert_allclose(by_input, leaf.grad.numpy(), rtol=1e-4, atol=1e-5)


def test_one_network_serves_a_stack_of_inputs():
    """The actor meets two batches in one pass: each comes out as by itself."""
    rng, sizes = default_rng(0), [4, 8, 2]
    networks, inputs = drawn(1, sizes, rng), inputs_of(rng, 2, 5, 4)
    for batch, output in zip(inputs, forward(networks, "relu", inputs, Room.of(2, 5, sizes)), strict=True):
        assert_allclose(forward(networks, "relu", batch, Room.of(1, 5, sizes))[0], output, rtol=1e-5)


def test_first_room_is_a_view():
    """What goes back through the first batch alone is what the pass left of it."""
    room = Room.of(2, 5, [4, 8, 2])
    half = room.first()
    half.error[-1][...] = 7.0
    assert room.error[-1][0].min() == 7.0
    assert room.error[-1][1].max() == 1.0


def test_without_gradients_none_is_computed():
    """The way to the inputs is the same."""
    rng, sizes = default_rng(0), [4, 8, 2]
    networks, inputs, room = drawn(2, sizes, rng), inputs_of(rng, 5, 4), Room.of(2, 5, sizes)
    forward(networks, "relu", inputs, room)
    room.error[-1][...] = 1.0
    gradient = tuple(np.empty_like(weight) for weight in networks)
    assert backward(networks, inputs, room, gradient).tobytes() == backward(networks, inputs, room, None).tobytes()


def test_an_invalid_product_is_no_warning():
    """Kernels of OpenBLAS raise the flag of one for finite numbers. A true one shows in the output."""
    room, networks = Room.of(1, 1, [1, 1]), (np.array([[[0.0], [0.0]]], np.float32),)
    assert np.isnan(forward(networks, "relu", np.array([[np.inf, 1.0]], np.float32), room))


def test_networks_are_views_of_one_vector():
    """An optimiser changes them all at once."""
    flat = np.zeros(count_parameters(2, [3, 5, 1]), np.float32)
    networks = networks_in(flat, 2, [3, 5, 1])
    assert [weight.shape for weight in networks] == [(2, 4, 5), (2, 6, 1)]
    flat[...] = 1.0
    assert all((weight == 1.0).all() for weight in networks)
    assert sum(weight.size for weight in networks) == flat.size


def test_first_weights_are_distributed_as_torch_draws_them():
    """Weights and biases within 1/sqrt(into), and spread as uniform numbers are."""
    (weight,) = drawn(1, [400, 500], default_rng(0))
    theirs = torch.nn.Linear(400, 500)
    for ours, other in ((weight[0, :-1], theirs.weight), (weight[0, -1], theirs.bias)):
        assert np.abs(ours).max() <= 0.05
        assert_allclose(ours.std(), other.detach().numpy().std(), rtol=0.1)
        assert_allclose(ours.mean(), 0.0, atol=0.005)
