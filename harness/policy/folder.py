"""The folder of a saved policy: a card in JSON, and arrays that no code is run to read."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import safetensors.numpy

from harness.arrays import Float32
from harness.errors import SchemaError
from harness.files.bounded import read_bytes, read_json
from harness.record.folder import CARD, WEIGHTS

FORMAT = 2
MOST_CARD_BYTES = 2**20
"""The most bytes of a card: ours have two thousand, most of them the training cell."""
MOST_WEIGHT_BYTES = 64 * 2**20
"""The most bytes of the arrays: those of three layers of 2,048, and 100 times what reaching takes."""
MOST_HEADER_BYTES = 2**20
"""The most bytes of the names and shapes before the arrays: 10,000 of them."""
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
    card = read_json(folder / CARD, MOST_CARD_BYTES)
    if card["format"] > FORMAT:
        raise SchemaError(f"{folder / CARD} has format {card['format']}, this version reads up to {FORMAT}")
    if card["format"] == 1:
        card = _from_format_1(card)
    if not isinstance(card["algorithm"], str):
        raise ValueError(f"the algorithm is {card['algorithm']!r}, no text")
    return card, _read_weights(folder / WEIGHTS)


def _read_weights(path: Path) -> Weights:
    """The arrays.

    Raises:
        ValueError: Their names alone are too many, or an array is not of float32, or has no numbers.
    """
    content = read_bytes(path, MOST_WEIGHT_BYTES)
    header = int.from_bytes(content[:8], "little")
    if header > MOST_HEADER_BYTES:
        raise ValueError(f"the header of {path.name} has {header:,} bytes, {MOST_HEADER_BYTES:,} are allowed")
    weights = safetensors.numpy.load(content)
    for name, array in weights.items():
        if array.dtype != np.float32:
            raise ValueError(f"{name} is {array.dtype}, not float32")
        if not array.size:
            raise ValueError(f"{name} has no numbers, {array.shape}")
    return weights


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
