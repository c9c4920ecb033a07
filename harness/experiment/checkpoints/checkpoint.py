"""Where a training that was killed goes on: one file in the partial folder of its cell, replaced by the next one.

``checkpoint.safetensors`` holds arrays and, as text, a JSON object. Reading it runs no code. With the rows of the trace
(`harness.record.trace`) and of replay buffers (`harness.experiment.checkpoints.checkpoint`), which stand in files of
their own and only grow, it is all that the rest of the training depends on: what the algorithm says that it needs, and
the state of the env. Of the physics it holds what the arms were told since their last resets: that is done again
(`harness.env.ideal`).
"""

import hashlib
import json
import shutil
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias
from urllib.parse import quote

import numpy as np
import safetensors
import safetensors.numpy
from numpy.typing import NDArray

from harness.errors import SchemaError
from harness.files.bounded import digest_of, files_in, is_partial, is_plain, whole_file, write_whole
from harness.files.plain import from_plain, to_plain
from harness.record.cell import KERNEL, Cell, write_log
from harness.record.folder import CHECKPOINT, LOG, TRACE
from harness.record.progress import Ring, TrainingState, prefixed, under
from harness.record.trace import require_rows


class RingPart(NamedTuple):
    """A file with rows `first` to `end` - 1, counted from the first that was ever written."""

    file: str
    first: int
    end: int
    digest: str


@dataclass(frozen=True)
class StoredRing:
    """The files that hold the rows of a ring.

    Attributes:
        capacity: See `harness.algorithm.Ring`.
        written: The same.
        parts: The files, oldest first.
    """

    capacity: int
    written: int
    parts: tuple[RingPart, ...] = ()

    @property
    def oldest(self) -> int:
        """The first row that is still in the ring."""
        return max(self.written - self.capacity, 0)


def store_ring(folder: Path, name: str, ring: Ring, before: StoredRing | None) -> StoredRing:
    """Write the rows that are new since `before`, if there is a `before`; returns where all rows are."""
    stored = StoredRing(len(next(iter(ring.columns.values()))), ring.written)
    if before is None or before.written > ring.written:  # the ring was emptied
        before = StoredRing(stored.capacity, 0)
    kept = tuple(part for part in before.parts if part.end > stored.oldest)
    first = max(before.written, stored.oldest)
    if first < ring.written:
        file = f"ring.{quote(name, safe='')}.{first}-{ring.written}.safetensors"
        rows = {column: _rows(array, first, ring.written) for column, array in ring.columns.items()}
        with whole_file(folder / file) as partial:
            safetensors.numpy.save_file(rows, partial)
        kept = (*kept, RingPart(file, first, ring.written, digest_of(folder / file)))
    return StoredRing(stored.capacity, stored.written, kept)


def _rows(column: NDArray[Any], first: int, end: int) -> NDArray[Any]:
    """Rows `first` to `end` - 1 of a ring's column, in order. It is no copy if they already stand in order."""
    top, count = first % len(column), end - first
    beyond = top + count - len(column)
    rows = column[top : top + count] if beyond <= 0 else np.concatenate([column[top:], column[:beyond]])
    return np.ascontiguousarray(rows)


def read_ring(folder: Path, stored: StoredRing) -> Ring:
    """The ring, as far as it was written.

    Raises:
        SchemaError: A file has other rows than the checkpoint tells.
    """
    columns: dict[str, Any] = {}
    for part in stored.parts:
        kept = np.arange(max(part.first, stored.oldest), part.end)
        for name, rows in safetensors.numpy.load_file(folder / part.file).items():
            if len(rows) != part.end - part.first:
                raise SchemaError(f"{part.file} has {len(rows):,} rows, not {part.end - part.first:,}")
            if name not in columns:
                columns[name] = np.empty((min(stored.written, stored.capacity), *rows.shape[1:]), rows.dtype)
            columns[name][kept % stored.capacity] = rows[kept - part.first]
    return Ring(columns, stored.written)


def require_rings(folder: Path, rings: Iterable[StoredRing]) -> None:
    """Check that all rows are as they were written.

    Raises:
        SchemaError: Rows, or a file, are missing or damaged.
    """
    rings = list(rings)
    for ring in rings:
        ends = [ring.oldest, *(part.end for part in ring.parts)]
        if ends[-1] != ring.written or any(part.first > end for part, end in zip(ring.parts, ends, strict=False)):
            raise SchemaError("rows of a ring are missing")
    for part in (part for ring in rings for part in ring.parts):
        path = folder / part.file
        if not is_plain(part.file) or not path.is_file() or digest_of(path) != part.digest:
            raise SchemaError(f"{part.file} is missing or damaged")


def discard_rings(folder: Path, but: Iterable[StoredRing] = ()) -> None:
    """Remove the files of all rings except those in `but`."""
    named = {part.file for ring in but for part in ring.parts}
    for path in folder.glob("ring.*.safetensors"):
        if path.name not in named:
            path.unlink()


FORMAT = 3
ABOUT = "harness.checkpoint"
ALGORITHM, ENV = "algorithm/", "env/"
THEN = " and then "


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """A checkpoint: the state of a training at some step.

    Attributes:
        steps: Environment steps that were done.
        origin: The cell, and what it ran on: it goes on only where these are the same, but for the ``kernel``, where
            all stand that it ran on; see `harness.experiment.provenance.blas_kernel`.
        algorithm: What the algorithm needs to go on, but for its rings.
        env: What the env needs.
        rings: Where the algorithm's rings are, by name, and those of the env, by their names behind `ENV`.
        rows: Of the trace; 0 where the env records it anew when it goes on.
        seconds: What the training took so far.
    """

    steps: int
    origin: Mapping[str, Any]
    algorithm: TrainingState
    env: TrainingState
    rings: Mapping[str, StoredRing] = field(default_factory=dict)
    rows: int = 0
    seconds: float = 0.0

    def write(self, folder: Path) -> None:
        """Put it into `folder` in place of an earlier one. At every moment one of the two is whole."""
        state = {**prefixed(ALGORITHM, self.algorithm), **prefixed(ENV, self.env)}
        arrays = {name: np.array(array, order="C") for name, array in state.items()}
        about = {
            "format": FORMAT,
            "steps": self.steps,
            "origin": self.origin,
            "rings": to_plain(self.rings),
            "rows": self.rows,
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
        SchemaError: It is damaged, of another format or of another origin, or the trace is.
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
        if {**about["origin"], "kernel": ""} != {**json.loads(json.dumps(origin)), "kernel": ""}:
            raise SchemaError("the sources, the versions or the commit have changed since")
        rings = {name: from_plain(StoredRing, ring) for name, ring in about["rings"].items()}
        if about["rows"]:
            require_rows(folder / TRACE, about["rows"])
        require_rings(folder, rings.values())
        algorithm, env = (under(prefix, arrays) for prefix in (ALGORITHM, ENV))
        return Checkpoint(about["steps"], about["origin"], algorithm, env, rings, about["rows"], about["seconds"])
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
    def rows(self) -> int:
        """Rows of the trace that were written before."""
        return self.checkpoint.rows if self.checkpoint else 0

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
    checkpoint, note, kernel = None, "", environment["machine"]["kernel"]
    if _left_behind(folder):
        checkpoint, reason = _usable_checkpoint(folder, origin, restore)
        note = f"went on after {checkpoint.steps} steps" if checkpoint else f"started over: {reason}"
        before = checkpoint.origin.get("kernel", "") if checkpoint else ""
        kernel = before if before.endswith(kernel) else f"{before}{THEN}{kernel}".removeprefix(THEN)
        if THEN in kernel:
            note += f", on the {KERNEL} {kernel}: no kernel alone gives these bytes"
        write_log(folder / LOG, f"an earlier process was killed; this one {note}")
    if not checkpoint:
        for path in _left_behind(folder):
            shutil.rmtree(path) if path.is_dir() else path.unlink()
    for path in filter(is_partial, files_in(folder)):
        path.unlink()  # was half written
    discard_rings(folder, but=checkpoint.rings.values() if checkpoint else ())
    return Attempt(folder, {**origin, "kernel": kernel}, every, checkpoint, note)


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
