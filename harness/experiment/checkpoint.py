"""Where a training that was killed goes on: one file in the partial folder of its cell, replaced by the next one.

``checkpoint.safetensors`` holds arrays and, as text, a JSON object. Reading it runs no code. With the finished parts of
the trace (`harness.experiment.trace_parts`) it is all that the rest of the training depends on: what the algorithm says
that it needs, and of the env the random streams and the counters. It holds no physics: a checkpoint is made where all
envs are about to start new episodes.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import safetensors
import safetensors.numpy

from harness.errors import SchemaError
from harness.experiment.trace_parts import require_parts
from harness.files.whole_file import write_whole
from harness.progress import TrainingState
from harness.record.folder import CHECKPOINT, TRACE

FORMAT = 1
ABOUT = "harness.checkpoint"
ALGORITHM, ENV = "algorithm/", "env/"


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """How far a training had come.

    Attributes:
        steps: Environment steps that were done.
        origin: The cell, and what it ran on: it goes on only where these are the same.
        algorithm: What the algorithm needs to go on.
        env: What the env needs.
        parts: SHA-256 of each finished part of the trace.
        seconds: What the training took so far.
    """

    steps: int
    origin: Mapping[str, Any]
    algorithm: TrainingState
    env: TrainingState
    parts: tuple[str, ...] = ()
    seconds: float = 0.0

    def write(self, folder: Path) -> None:
        """Put it into `folder` in place of an earlier one: at every moment one of the two is whole."""
        arrays = {name: np.array(array, order="C") for name, array in self._arrays().items()}
        about = {
            "format": FORMAT,
            "steps": self.steps,
            "origin": self.origin,
            "parts": self.parts,
            "seconds": self.seconds,
            "digest": _digest(arrays),
        }
        write_whole(folder / CHECKPOINT, safetensors.numpy.save(arrays, {ABOUT: json.dumps(about)}))

    def _arrays(self) -> dict[str, Any]:
        groups = ((ALGORITHM, self.algorithm), (ENV, self.env))
        return {f"{prefix}{name}": array for prefix, state in groups for name, array in state.items()}


def read_checkpoint(folder: Path, origin: Mapping[str, Any]) -> Checkpoint:
    """The checkpoint in the partial folder of a cell.

    Args:
        folder: Of the cell.
        origin: The cell, and what it is to run on now.

    Raises:
        SchemaError: It is damaged, of a newer format or of another origin, or a part of the trace is.
    """
    try:
        with safetensors.safe_open(folder / CHECKPOINT, framework="numpy") as file:
            about = json.loads(file.metadata()[ABOUT])
            arrays = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118 (it is no mapping)
        if about["format"] > FORMAT:
            raise SchemaError(f"it has format {about['format']}, this version reads up to {FORMAT}")
        if about["digest"] != _digest(arrays):
            raise SchemaError("its arrays are damaged")
        # Through JSON, as what it is compared with went.
        if about["origin"] != json.loads(json.dumps(origin)):
            raise SchemaError("the sources, the versions or the commit have changed since")
        require_parts(folder / TRACE, about["parts"])
        algorithm, env = (_under(arrays, prefix) for prefix in (ALGORITHM, ENV))
        return Checkpoint(about["steps"], origin, algorithm, env, tuple(about["parts"]), about["seconds"])
    except (OSError, ValueError, KeyError, TypeError, safetensors.SafetensorError) as error:
        raise SchemaError(f"it cannot be read: {error!r}") from error


def _under(arrays: Mapping[str, Any], prefix: str) -> TrainingState:
    return {name.removeprefix(prefix): array for name, array in arrays.items() if name.startswith(prefix)}


def _digest(arrays: Mapping[str, Any]) -> str:
    """SHA-256 of all arrays and their names: a flipped bit is no other training."""
    digest = hashlib.sha256()
    for name in sorted(arrays):
        array = arrays[name]
        digest.update(f"{name} {array.dtype} {array.shape}".encode())
        digest.update(array.tobytes())
    return digest.hexdigest()
