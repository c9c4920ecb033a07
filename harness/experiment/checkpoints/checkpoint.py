"""Where a training that was killed goes on: one file in the partial folder of its cell, replaced by the next one.

``checkpoint.safetensors`` holds arrays and, as text, a JSON object. Reading it runs no code. With the finished parts of
the trace (`harness.experiment.checkpoints.trace_parts`) and the rows of replay buffers
(`harness.experiment.checkpoints.stored_rings`), which stand in files of their own and only grow, it is all that the
rest of the training depends on: what the algorithm says that it needs, and the state of the env. Of the physics it
holds what the arms were told since their last resets: that is done again (`harness.env.logged_simulation`).
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import safetensors
import safetensors.numpy

from harness.errors import SchemaError
from harness.experiment.checkpoints.stored_rings import StoredRing, discard_rings, read_ring, require_rings, store_ring
from harness.experiment.checkpoints.trace_parts import require_parts
from harness.files.whole_file import write_whole
from harness.progress import Ring, TrainingState, prefixed, under
from harness.record.folder import CHECKPOINT, TRACE

FORMAT = 2
ABOUT = "harness.checkpoint"
ALGORITHM, ENV = "algorithm/", "env/"


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """A checkpoint: the state of a training at some step.

    Attributes:
        steps: Environment steps that were done.
        origin: The cell, and what it ran on: it goes on only where these are the same.
        algorithm: What the algorithm needs to go on, but for its rings.
        env: What the env needs.
        rings: Where the algorithm's rings are, by name, and those of the env, by their names behind `ENV`.
        parts: SHA-256 of each finished part of the trace.
        seconds: What the training took so far.
    """

    steps: int
    origin: Mapping[str, Any]
    algorithm: TrainingState
    env: TrainingState
    rings: Mapping[str, StoredRing] = field(default_factory=dict)
    parts: tuple[str, ...] = ()
    seconds: float = 0.0

    def write(self, folder: Path) -> None:
        """Put it into `folder` in place of an earlier one. At every moment one of the two is whole."""
        arrays = {name: np.array(array, order="C") for name, array in self._arrays().items()}
        about = {
            "format": FORMAT,
            "steps": self.steps,
            "origin": self.origin,
            "rings": {name: asdict(ring) for name, ring in self.rings.items()},
            "parts": self.parts,
            "seconds": self.seconds,
        }
        text = json.dumps({**about, "digest": _digest(about, arrays)})
        write_whole(folder / CHECKPOINT, safetensors.numpy.save(arrays, {ABOUT: text}))
        discard_rings(folder, but=self.rings.values())

    def restored(self, folder: Path) -> TrainingState:
        """What the algorithm needs, with its rings, which are read from `folder`."""
        rings = {name: ring for name, ring in self.rings.items() if not name.startswith(ENV)}
        return {**self.algorithm, **{name: read_ring(folder, ring) for name, ring in rings.items()}}

    def restored_env(self, folder: Path) -> TrainingState:
        """What the env needs, with its rings, which are read from `folder`."""
        return {**self.env, **{name: read_ring(folder, ring) for name, ring in under(ENV, self.rings).items()}}

    def _arrays(self) -> TrainingState:
        return {**prefixed(ALGORITHM, self.algorithm), **prefixed(ENV, self.env)}


def store(
    folder: Path, algorithm: TrainingState, env: TrainingState, before: Mapping[str, StoredRing]
) -> dict[str, Any]:
    """Put what a training needs to go on to where a `Checkpoint` names it.

    Args:
        folder: The partial folder of its cell.
        algorithm: What the algorithm needs.
        env: What the env needs.
        before: Where the rings of the last checkpoint are.

    Returns:
        The fields `algorithm`, `env` and `rings` of the checkpoint.
    """
    rings = {name: value for name, value in {**algorithm, **prefixed(ENV, env)}.items() if isinstance(value, Ring)}
    return {
        "algorithm": {name: value for name, value in algorithm.items() if not isinstance(value, Ring)},
        "env": {name: value for name, value in env.items() if not isinstance(value, Ring)},
        "rings": {name: store_ring(folder, name, ring, before.get(name)) for name, ring in rings.items()},
    }


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
        if about["format"] != FORMAT:
            raise SchemaError(f"it has format {about['format']}, this version reads {FORMAT}")
        if about.pop("digest") != _digest(about, arrays):
            raise SchemaError("it is damaged")
        # Through JSON, as what it is compared with went.
        if about["origin"] != json.loads(json.dumps(origin)):
            raise SchemaError("the sources, the versions or the commit have changed since")
        rings = {name: StoredRing.from_json(ring) for name, ring in about["rings"].items()}
        require_parts(folder / TRACE, about["parts"])
        require_rings(folder, rings.values())
        algorithm, env = (under(prefix, arrays) for prefix in (ALGORITHM, ENV))
        return Checkpoint(about["steps"], origin, algorithm, env, rings, tuple(about["parts"]), about["seconds"])
    except (OSError, ValueError, KeyError, TypeError, safetensors.SafetensorError) as error:
        raise SchemaError(f"it cannot be read: {error!r}") from error


def _digest(about: Mapping[str, Any], arrays: Mapping[str, Any]) -> str:
    """SHA-256 of everything in a checkpoint. It finds a flipped bit, which would make another training of it."""
    digest = hashlib.sha256(json.dumps(about, sort_keys=True).encode())
    for name in sorted(arrays):
        array = arrays[name]
        digest.update(f"{name} {array.dtype} {array.shape}".encode())
        digest.update(array.tobytes())
    return digest.hexdigest()
