"""Where a training that was killed goes on: one file in the partial folder of its cell, replaced by the next one.

``checkpoint.safetensors`` holds arrays and, as text, a JSON object. Reading it runs no code. With the finished parts of
the trace (`harness.experiment.checkpoints.trace_parts`) and the rows of replay buffers
(`harness.experiment.checkpoints.stored_rings`), which stand in files of their own and only grow, it is all that the
rest of the training depends on: what the algorithm says that it needs, and the state of the env. Of the physics it
holds what the arms were told since their last resets: that is done again (`harness.env.logged_simulation`).
"""

import hashlib
import json
import shutil
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import safetensors
import safetensors.numpy

from harness.errors import SchemaError
from harness.experiment.checkpoints.stored_rings import StoredRing, discard_rings, read_ring, require_rings, store_ring
from harness.experiment.checkpoints.trace_parts import require_parts
from harness.files.whole_file import is_partial, write_whole
from harness.progress import Ring, TrainingState, prefixed, under
from harness.record.cell import Cell
from harness.record.folder import CHECKPOINT, LOG, TRACE
from harness.record.manifest import write_log

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
        state = {**prefixed(ALGORITHM, self.algorithm), **prefixed(ENV, self.env)}
        arrays = {name: np.array(array, order="C") for name, array in state.items()}
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


Restore: TypeAlias = Callable[[TrainingState], None]
"""Puts an env where a checkpoint says; raises SchemaError if it cannot."""


@dataclass(frozen=True, eq=False)
class Attempt:
    """What a training starts with.

    Attributes:
        folder: The cell's partial folder.
        origin: The cell, and what it runs on; see `harness.experiment.checkpoints.checkpoint.Checkpoint`.
        every: See `harness.executor.CellOptions.checkpoint_every`.
        checkpoint: To go on from, if any.
        note: What there is to say if a process was killed before; else empty.
    """

    folder: Path
    origin: Mapping[str, Any]
    every: int | None = None
    checkpoint: Checkpoint | None = None
    note: str = ""
    _start: float = field(default_factory=time.perf_counter, init=False)

    @property
    def begun_from(self) -> int:
        """Environment steps that were done before."""
        return self.checkpoint.steps if self.checkpoint else 0

    @property
    def parts(self) -> tuple[str, ...]:
        """SHA-256 of each part of the trace that was finished before."""
        return self.checkpoint.parts if self.checkpoint else ()

    @property
    def seconds(self) -> float:
        """Seconds of training so far, without the time after the checkpoint, whose work was lost."""
        return time.perf_counter() - self._start + (self.checkpoint.seconds if self.checkpoint else 0.0)


def begin_attempt(
    cell: Cell,
    folder: Path,
    environment: Mapping[str, Any],
    every: int | None,
    restore: Restore,
) -> Attempt:
    """Go on from the checkpoint in a partial folder, or start over. The log says which of the two.

    Args:
        cell: To be trained.
        folder: Its partial folder; emptied, but for the log, where nothing in it is of use.
        environment: What the cell runs on now; see `harness.experiment.provenance.describe_environment`.
        every: See `harness.executor.CellOptions.checkpoint_every`.
        restore: Of the env that the cell is trained on.
    """
    origin = {"cell": cell.id, **{key: environment[key] for key in ("versions", "commit", "sources")}}
    checkpoint, note = None, ""
    if _left_behind(folder):
        checkpoint, reason = _usable_checkpoint(folder, origin, restore)
        note = f"went on after {checkpoint.steps} steps" if checkpoint else f"started over: {reason}"
        write_log(folder / LOG, f"an earlier process was killed; this one {note}")
    if not checkpoint:
        for path in _left_behind(folder):
            shutil.rmtree(path) if path.is_dir() else path.unlink()
    for path in filter(is_partial, folder.iterdir()):
        path.unlink()  # a checkpoint that was half written
    discard_rings(folder, but=checkpoint.rings.values() if checkpoint else ())
    return Attempt(folder, origin, every, checkpoint, note)


def _usable_checkpoint(folder: Path, origin: Mapping[str, Any], restore: Restore) -> tuple[Checkpoint | None, str]:
    """The checkpoint, after the env was restored from it; or the reason why none can be used."""
    if not (folder / CHECKPOINT).is_file():
        return None, "no checkpoint was left"
    try:
        checkpoint = read_checkpoint(folder, origin)
        restore(checkpoint.restored_env(folder))
    except SchemaError as error:
        return None, f"{CHECKPOINT} is of no use: {error}"
    return checkpoint, ""


def _left_behind(folder: Path) -> list[Path]:
    """What an earlier process left beside the log."""
    return [path for path in folder.iterdir() if path.name != LOG]
