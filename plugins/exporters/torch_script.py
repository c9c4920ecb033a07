"""A TorchScript model, which C++ programs load without Python."""

import io
import json
import warnings
from collections.abc import Mapping
from typing import Any

import torch

from harness.authoring.commands import MEAN, STD, ContinuousNetwork
from harness.policy import Network

CARD = "card.json"
ACTIVATIONS = {"relu": torch.nn.ReLU, "tanh": torch.nn.Tanh}


class Scale(torch.nn.Module):
    """Scales observations: subtracts their mean and divides by their standard deviation."""

    mean: torch.Tensor
    std: torch.Tensor

    def __init__(self, mean: torch.Tensor, std: torch.Tensor) -> None:
        super().__init__()
        self.register_buffer("mean", mean)
        self.register_buffer("std", std)

    def forward(self, observation: torch.Tensor) -> torch.Tensor:
        """Scaled observations, (batch, observation_size), of observations of the same shape."""
        return (observation - self.mean) / self.std


class Box(torch.nn.Module):
    """Clips actions to the action box. If `squashes`, tanh squashes them into the box before."""

    low: torch.Tensor
    high: torch.Tensor
    half_range: torch.Tensor

    def __init__(self, low: torch.Tensor, high: torch.Tensor, half: torch.Tensor, squashes: bool) -> None:
        super().__init__()
        self.register_buffer("low", low)
        self.register_buffer("high", high)
        self.register_buffer("half_range", half)
        self.squashes = squashes

    def forward(self, action: torch.Tensor) -> torch.Tensor:
        """Actions in the box, (batch, action_size), from numbers of the same shape."""
        if self.squashes:
            action = (torch.tanh(action) + 1.0) * self.half_range + self.low
        return torch.minimum(torch.maximum(action, self.low), self.high)


class First(torch.nn.Module):
    """Chooses the largest value; the first of them if several are equal."""

    def forward(self, values: torch.Tensor) -> torch.Tensor:
        """The numbers of the choices, (batch,), for values (batch, choices)."""
        return torch.argmax(values, dim=1)


def model_of(policy: Network, card: Mapping[str, Any]) -> bytes:
    """The bytes of a model's file, for `torch.jit.load`. The policy's card is the extra file ``card.json``.

    The model takes (batch, observation_size) of float32. It returns (batch, action_size) of float32, or (batch,) of
    int64 if the policy chooses between discrete actions.
    """
    module = torch.nn.Sequential(*_steps(policy)).eval().requires_grad_(False)
    file = io.BytesIO()
    with warnings.catch_warnings():
        # torch advises torch.export instead. But its files need Python, so it cannot replace TorchScript here.
        warnings.filterwarnings("ignore", "`torch.jit.*` is deprecated", DeprecationWarning)
        torch.jit.save(torch.jit.script(module), file, _extra_files={CARD: json.dumps(card)})
    return file.getvalue()


def _steps(policy: Network) -> list[torch.nn.Module]:
    steps: list[torch.nn.Module] = []
    if policy.is_normalised:
        steps.append(Scale(*(torch.tensor(policy.weights[name]) for name in (MEAN, STD))))
    for index in range(policy.depth):
        steps += [_linear(policy, f"hidden.{index}"), ACTIVATIONS[policy.activation]()]
    steps.append(_linear(policy, policy.heads[0]))
    if isinstance(policy, ContinuousNetwork):
        low, high, half = (torch.tensor(bound) for bound in policy.bounds)
        steps.append(Box(low, high, half, policy.squashes))
    else:
        steps.append(First())
    return steps


def _linear(policy: Network, layer: str) -> torch.nn.Linear:
    weight, bias = (torch.tensor(policy.weights[f"{layer}.{part}"]) for part in ("weight", "bias"))
    linear = torch.nn.Linear(weight.shape[1], weight.shape[0])
    linear.load_state_dict({"weight": weight, "bias": bias})
    return linear
