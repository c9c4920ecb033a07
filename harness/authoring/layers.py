"""Turns the layers of any library into the weights of a policy."""

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from harness.arrays import Float32
from harness.errors import UsageError

Layer: TypeAlias = tuple[ArrayLike, ArrayLike]
"""Weight, (out, in), and bias, (out,)."""


def layer_weights(hidden: Sequence[Layer], **heads: Layer) -> dict[str, Float32]:
    """The weights of a policy, by the names that policies use; each is a copy in float32.

    Args:
        hidden: Weight, (out, in), and bias, (out,), of each hidden layer. The first layer gets the observation. PyTorch
            stores weights in this shape; Flax and Keras store them transposed.
        heads: Weight and bias of each linear head on the last hidden layer, by name. The kind of policy says which
            heads it needs: ``mean``, ``log_std``, ``logits`` or ``value``.

    Returns:
        What `Network.weights` takes.

    Raises:
        UsageError: A layer does not fit the one before it. The message has the layer, its shapes and allowed ones.
    """
    weights: dict[str, Float32] = {}
    width: int | None = None
    for index, layer in enumerate(hidden):
        width = _add(weights, f"hidden.{index}", layer, width)
    for name, layer in heads.items():
        _add(weights, name, layer, width)
    return weights


def _add(weights: dict[str, Float32], name: str, layer: Layer, inputs: int | None) -> int:
    """Returns how many outputs the layer has."""
    weight, bias = (np.array(part, np.float32) for part in layer)
    fits = weight.ndim == 2 and bias.shape == weight.shape[:1] and inputs in {None, weight.shape[1]}
    if not fits:
        wanted = "in" if inputs is None else inputs
        raise UsageError(
            f"layer {name}: weight {weight.shape} and bias {bias.shape}; allowed: (out, {wanted}) and (out,). "
            "Transpose the weight if its library keeps it as (in, out)"
        )
    weights[f"{name}.weight"], weights[f"{name}.bias"] = weight, bias
    return int(weight.shape[0])
