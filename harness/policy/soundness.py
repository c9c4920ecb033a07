"""Whether a network that was read from a file can act."""

import numpy as np

from harness.policy.network import ACTIVATIONS, MEAN, STD, Network


def require_sound(network: Network, outputs: int) -> None:
    """Look at what `act` would meet much later, or never complain of.

    Args:
        network: As it was read.
        outputs: Of each head.

    Raises:
        KeyError: A part is missing.
        ValueError: A part cannot be, or does not fit the others.
    """
    if network.activation not in ACTIVATIONS:
        raise ValueError(f"no activation {network.activation!r}; there is: {', '.join(ACTIVATIONS)}")
    for name, array in network.weights.items():
        if not np.isfinite(array).all():
            raise ValueError(f"{name} has numbers that are not finite")
    layers = {int(name.split(".")[1]) for name in network.weights if name.startswith("hidden.")}
    width = None
    for index in range(1 + max(layers, default=-1)):
        width = _outputs_of(network, f"hidden.{index}", width)
    if network.depth > len(layers):
        raise ValueError("a hidden layer is there twice")
    for head in network.heads:
        if _outputs_of(network, head, width) != outputs:
            raise ValueError(f"{head} does not have {outputs} outputs")
    if MEAN in network.weights or STD in network.weights:
        _require_scaling(network)


def _outputs_of(network: Network, layer: str, inputs: int | None) -> int:
    """The width of a layer; `inputs` is that of the layer before, None where there is none."""
    weight, bias = network.weights[f"{layer}.weight"], network.weights[f"{layer}.bias"]
    if weight.ndim != 2 or bias.shape != weight.shape[:1] or inputs not in {None, weight.shape[1]}:
        raise ValueError(f"{layer} is {weight.shape} and {bias.shape}, on {inputs or weight.shape[-1:]} inputs")
    return int(weight.shape[0])


def _require_scaling(network: Network) -> None:
    for name in (MEAN, STD):
        if network.weights[name].shape != (network.observation_size,):
            raise ValueError(f"{name} is {network.weights[name].shape}, on {network.observation_size} numbers")
    if not (network.weights[STD] > 0.0).all():
        raise ValueError(f"{STD} is not above 0 everywhere")
