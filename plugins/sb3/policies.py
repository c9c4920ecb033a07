"""The networks of stable-baselines3 as policies that act with numpy alone."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from harness import Float32
from harness.policy import Categorical, Deterministic, Gaussian, Greedy, Policy, SquashedGaussian, layer_weights


def policy_from(model: Any, activation: str, algorithm: str, noise: float = 0.1) -> Policy:
    """The policy of a model, in copies: that of SAC, TD3, PPO on continuous or discrete actions, or a deep Q network.

    Args:
        model: By its networks it is known whose policy it is.
        activation: Between the layers, ``relu`` or ``tanh``.
        algorithm: The name that the policy tells.
        noise: In drawn actions of TD3's policy, as a share of half the box; of a deep Q network the share of drawn
            actions that are random. The other policies have a spread of their own.
    """
    policy, space = model.policy, model.action_space
    if hasattr(model, "q_net"):
        *hidden, value = _linear_layers(model.q_net.q_net)
        return Greedy(_weights(hidden, value=value), activation, int(space.n), algorithm, noise)
    if hasattr(policy, "mlp_extractor"):
        hidden = policy.mlp_extractor.policy_net
        if hasattr(space, "n"):
            return Categorical(_weights(hidden, logits=policy.action_net), activation, int(space.n), algorithm)
        weights = _weights(hidden, mean=policy.action_net)
        return Gaussian(
            {**weights, "log_std": policy.log_std.detach().numpy().astype(np.float32)},
            activation,
            *_box(space),
            algorithm,
        )
    actor = policy.actor
    if hasattr(actor, "log_std"):
        weights = _weights(actor.latent_pi, mean=actor.mu, log_std=actor.log_std)
        return SquashedGaussian(weights, activation, *_box(space), algorithm)
    *hidden, mean = _linear_layers(actor.mu)
    return Deterministic(_weights(hidden, mean=mean), activation, *_box(space), algorithm, noise)


def _weights(hidden: Iterable[Any], **heads: Any) -> dict[str, Float32]:
    """Copies of the layers' weights, under the names that policies give them."""
    layers = [_parts(layer) for layer in _linear_layers(hidden)]
    return layer_weights(layers, **{name: _parts(layer) for name, layer in heads.items()})


def _parts(layer: Any) -> tuple[Float32, Float32]:
    return layer.weight.detach().numpy(), layer.bias.detach().numpy()


def _linear_layers(layers: Iterable[Any]) -> list[Any]:
    return [layer for layer in layers if hasattr(layer, "weight")]


def _box(space: Any) -> tuple[tuple[float, ...], tuple[float, ...]]:
    return tuple(space.low.tolist()), tuple(space.high.tolist())
