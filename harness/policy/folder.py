"""The folder of a saved policy: a card in JSON, and arrays that no code is run to read."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import safetensors.numpy

from harness.arrays import Float32
from harness.errors import SchemaError
from harness.record.folder import CARD, WEIGHTS

FORMAT = 2
Weights = Mapping[str, Float32]


def write_folder(folder: Path, card: Mapping[str, Any], weights: Weights) -> None:
    """Write `card` and `weights` into `folder`, which is made."""
    folder.mkdir(parents=True, exist_ok=True)
    # safetensors writes the memory as it lies: a transposed view would come back scrambled.
    arrays = {name: np.ascontiguousarray(weight) for name, weight in weights.items()}
    safetensors.numpy.save_file(arrays, folder / WEIGHTS)
    (folder / CARD).write_text(json.dumps({"format": FORMAT, **card}, indent=1, allow_nan=False) + "\n")


def read_folder(folder: Path) -> tuple[dict[str, Any], Weights]:
    """The card, as this format has it, and the arrays.

    Raises:
        SchemaError: A later version wrote it.
    """
    card = json.loads((folder / CARD).read_text())
    if card["format"] > FORMAT:
        raise SchemaError(f"{folder / CARD} has format {card['format']}, this version reads up to {FORMAT}")
    weights = safetensors.numpy.load_file(folder / WEIGHTS)
    if card["format"] == 1:
        card = _from_format_1(card)
    for name, array in weights.items():
        if array.dtype != np.float32:
            raise ValueError(f"{name} is {array.dtype}, not float32")
    return card, weights


def _from_format_1(card: Mapping[str, Any]) -> dict[str, Any]:
    """Format 1 knew one kind, and kept sizes and bounds side by side."""
    return {
        "format": FORMAT,
        "kind": "squashed-gaussian",
        "algorithm": card["algorithm"],
        "observation": {"size": card["observation_size"]},
        "action": {"type": "continuous", "low": card["action_low"], "high": card["action_high"]},
        "activation": card["activation"],
        "normalisation": None,
        "cell": None,
    }
