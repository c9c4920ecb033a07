"""One process that trains a cell: from the start, or from the checkpoint of a process that was killed."""

import shutil
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

from harness.errors import SchemaError
from harness.experiment.checkpoints.checkpoint import Checkpoint, read_checkpoint
from harness.experiment.checkpoints.stored_rings import discard_rings
from harness.files.whole_file import is_partial
from harness.progress import TrainingState
from harness.record.cell import Cell
from harness.record.folder import CHECKPOINT, LOG
from harness.record.manifest import write_log

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
        _empty(folder)
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


def _empty(folder: Path) -> None:
    for path in _left_behind(folder):
        shutil.rmtree(path) if path.is_dir() else path.unlink()
