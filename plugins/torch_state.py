"""Turns torch's tensors and optimisers into arrays for a checkpoint, and back, without pickle."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.algorithm import TrainingState

if TYPE_CHECKING:
    from torch import Tensor
    from torch.optim import Optimizer


def pack_tensors(tensors: "Mapping[str, Tensor]") -> dict[str, Any]:
    """Copies of the tensors as arrays, under the same names."""
    return {name: tensor.detach().numpy().copy() for name, tensor in tensors.items()}


def restore_tensors(tensors: "Mapping[str, Tensor]", state: TrainingState) -> None:
    """Copy the arrays that `pack_tensors` returned into the tensors, in place."""
    import torch

    with torch.no_grad():
        for name, tensor in tensors.items():
            tensor.copy_(torch.from_numpy(np.array(state[name])))


def pack_optimizer(optimizer: "Optimizer") -> dict[str, Any]:
    """What an optimiser remembers of each parameter, such as its moments, as arrays named ``INDEX.KEY``.

    Its settings are left out, because the new optimiser is made with them.
    """
    remembered = optimizer.state_dict()["state"].items()
    return {
        name: array
        for index, moments in remembered
        for name, array in pack_tensors({f"{index}.{key}": moment for key, moment in moments.items()}).items()
    }


def restore_optimizer(optimizer: "Optimizer", state: TrainingState) -> None:
    """Give an optimiser what `pack_optimizer` returned. The parameters must stand in the same order."""
    import torch

    moments: dict[int, dict[str, Tensor]] = {}
    for name, array in state.items():
        index, key = name.split(".")
        moments.setdefault(int(index), {})[key] = torch.from_numpy(np.array(array))
    optimizer.load_state_dict({**optimizer.state_dict(), "state": moments})
