"""The networks of stable-baselines3 as policies that act with numpy alone."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from harness.arrays import Float32
from harness.authoring import layer_weights
from harness.policy import Categorical, Deterministic, Gaussian, Greedy, SquashedGaussian


def squashed_gaussian(model: Any, activation: str, algorithm: str) -> SquashedGaussian:
    """The policy of SAC's actor."""
    actor = model.policy.actor
    weights = _weights(actor.latent_pi, mean=actor.mu, log_std=actor.log_std)
    return SquashedGaussian(weights, activation, *_box(model), algorithm)


def deterministic(model: Any, activation: str, algorithm: str, noise: float) -> Deterministic:
    """The policy of TD3's actor."""
    *hidden, mean = _linear_layers(model.policy.actor.mu)
    return Deterministic(_weights(hidden, mean=mean), activation, *_box(model), algorithm, noise)


def gaussian(model: Any, activation: str, algorithm: str) -> Gaussian:
    """The policy of PPO's actor on continuous actions."""
    policy = model.policy
    weights = _weights(policy.mlp_extractor.policy_net, mean=policy.action_net)
    weights["log_std"] = _array(policy.log_std)
    return Gaussian(weights, activation, *_box(model), algorithm)


def categorical(model: Any, activation: str, algorithm: str) -> Categorical:
    """The policy of PPO's actor on discrete actions."""
    policy = model.policy
    weights = _weights(policy.mlp_extractor.policy_net, logits=policy.action_net)
    return Categorical(weights, activation, int(model.action_space.n), algorithm)


def greedy(model: Any, activation: str, algorithm: str, epsilon: float) -> Greedy:
    """The policy of a deep Q network."""
    *hidden, value = _linear_layers(model.q_net.q_net)
    return Greedy(_weights(hidden, value=value), activation, int(model.action_space.n), algorithm, epsilon)


def _weights(hidden: Iterable[Any], **heads: Any) -> dict[str, Float32]:
    """Copies of the layers' weights, under the names that policies give them."""
    layers = [_parts(layer) for layer in _linear_layers(hidden)]
    return layer_weights(layers, **{name: _parts(layer) for name, layer in heads.items()})


def _parts(layer: Any) -> tuple[Float32, Float32]:
    return _array(layer.weight), _array(layer.bias)


def _linear_layers(layers: Iterable[Any]) -> list[Any]:
    return [layer for layer in layers if hasattr(layer, "weight")]


def _array(parameter: Any) -> Float32:
    array: Float32 = parameter.detach().numpy().astype(np.float32, copy=True)
    return array


def _box(model: Any) -> tuple[tuple[float, ...], tuple[float, ...]]:
    space = model.action_space
    return tuple(space.low.tolist()), tuple(space.high.tolist())
