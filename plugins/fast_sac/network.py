"""Multi-layer perceptrons side by side, forwards and backwards, in arrays that are allocated before.

A bias is the weight of an input that is always 1. So the inputs of every layer end with a column of ones, and one
matrix product computes weights and biases, forwards and backwards.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Self, TypeAlias

import numpy as np

from harness import Float32

Networks: TypeAlias = tuple[Float32, ...]
"""Weights of each layer, or their gradients, (count, into + 1, out); the last row of the inputs' axis is the bias."""


def count_parameters(count: int, sizes: Sequence[int]) -> int:
    """How many weights and biases `count` networks have, with layers of these sizes, input and output included."""
    return count * sum((into + 1) * out for into, out in pairwise(sizes))


def networks_in(flat: Float32, count: int, sizes: Sequence[int]) -> Networks:
    """Views of `flat` as `count` networks. `flat` has as many numbers as `count_parameters` says."""
    layers, start = [], 0
    for into, out in pairwise(sizes):
        end = start + count * (into + 1) * out
        layers.append(flat[start:end].reshape(count, into + 1, out))
        start = end
    return tuple(layers)


def draw_weights(networks: Networks, rng: np.random.Generator) -> None:
    """First weights and biases: uniform within 1/sqrt(into), as in torch's linear layers."""
    for weight in networks:
        bound = 1.0 / np.sqrt(weight.shape[1] - 1)
        weight[...] = rng.uniform(-bound, bound, weight.shape)


@dataclass(frozen=True, eq=False)
class Room:
    """What a pass through the networks leaves for the way back. The next pass overwrites it.

    Attributes:
        value: Values of each hidden layer after the activation, (count, rows, out + 1), with ones in the last column;
            then the output, (count, rows, out).
        slope: Slopes of the activation, (count, rows, out + 1) for each hidden layer.
        error: Gradients of the loss by each layer's values before the activation, (count, rows, out). Write the
            gradient by the output there before you call `backward`.
    """

    value: tuple[Float32, ...]
    slope: tuple[Float32, ...]
    error: tuple[Float32, ...]

    @classmethod
    def of(cls, count: int, rows: int, sizes: Sequence[int]) -> Self:
        """Room for `rows` inputs of each of `count` networks."""

        def ones(outs: Sequence[int]) -> tuple[Float32, ...]:
            return tuple(np.ones((count, rows, out), np.float32) for out in outs)

        hidden = [out + 1 for out in sizes[1:-1]]
        return cls(ones([*hidden, sizes[-1]]), ones(hidden), ones(sizes[1:]))

    def first(self) -> Self:
        """The room of the first network, as views."""
        return type(self)(*(tuple(array[:1] for array in arrays) for arrays in vars(self).values()))


def product(first: Float32, second: Float32, out: Float32 | None = None) -> Float32:
    """The matrix product, without numpy's warning of an invalid operation.

    OpenBLAS has left the flag of one behind for finite numbers (numpy's issue 24067, OpenBLAS's 1924), and numpy cannot
    know which operation raised it. A true NaN stays in the result, and in the next action, which is refused.
    """
    with np.errstate(invalid="ignore"):
        return np.matmul(first, second, out=out)


def relu(value: Float32, slope: Float32) -> None:
    """Apply it to `value` in place, and write its slope; one comparison does both. The column of ones stays ones."""
    np.greater(value, 0.0, out=slope, casting="unsafe")
    np.multiply(value, slope, out=value)


def tanh(value: Float32, slope: Float32) -> None:
    """Apply it to `value` in place, and write its slope. The column of ones is left alone."""
    value, slope = value[..., :-1], slope[..., :-1]
    np.tanh(value, out=value)
    np.multiply(value, value, out=slope)
    np.subtract(1.0, slope, out=slope)


ACTIVATIONS: dict[str, Callable[[Float32, Float32], None]] = {"relu": relu, "tanh": tanh}


def forward(networks: Networks, activation: str, inputs: Float32, room: Room) -> Float32:
    """The output of the networks for `inputs`.

    Args:
        networks: `count` networks, or one for all inputs.
        activation: Between the layers.
        inputs: (count, rows, into + 1), or (rows, into + 1), the same for all; the last column is 1.
        room: Keeps what `backward` needs.

    Returns:
        (count, rows, out), in `room`.
    """
    *hidden, last = networks
    values, activate = inputs, ACTIVATIONS[activation]
    for weight, value, slope in zip(hidden, room.value, room.slope, strict=False):
        product(values, weight, out=value[..., :-1])
        activate(value, slope)
        values = value
    return product(values, last, out=room.value[-1])


def backward(networks: Networks, inputs: Float32, room: Room, gradient: Networks | None) -> Float32:
    """Go back through the last pass, from the gradient by the output, which stands in ``room.error[-1]``.

    Args:
        networks: As in that pass.
        inputs: As in that pass.
        room: The room of that pass.
        gradient: Filled with the gradients, summed over rows; None if they are not wanted.

    Returns:
        The error of the first layer, (count, rows, out). Multiply it by that layer's weights for the gradient by the
        inputs.
    """
    for layer in reversed(range(len(networks))):
        error = room.error[layer]
        if gradient is not None:
            before = room.value[layer - 1] if layer else inputs
            product(before.swapaxes(-1, -2), error, out=gradient[layer])
        if layer:
            weight = networks[layer][:, :-1].swapaxes(-1, -2)
            # With one output this is the product of a column and a row, for which a matrix product is slow.
            times = np.multiply if weight.shape[1] == 1 else product
            times(error, weight, out=room.error[layer - 1])
            np.multiply(room.error[layer - 1], room.slope[layer - 1][..., :-1], out=room.error[layer - 1])
    return room.error[0]
