"""One process that trains a cell: from the start, or from the checkpoint of a process that was killed."""

import shutil
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from harness.errors import SchemaError
from harness.experiment.checkpoint import Checkpoint, read_checkpoint
from harness.files.whole_file import is_partial
from harness.record.cell import Cell
from harness.record.folder import CHECKPOINT, LOG
from harness.record.log import write_log


@dataclass(frozen=True, eq=False)
class Attempt:
    """What a training starts with.

    Attributes:
        folder: The cell's partial folder.
        origin: The cell, and what it runs on; see `harness.experiment.checkpoint.Checkpoint`.
        every: Environment steps from one checkpoint to the next, at least; 0 for none.
        checkpoint: To go on from, if any.
        note: What there is to say if a process was killed before; else empty.
    """

    folder: Path
    origin: Mapping[str, Any]
    every: int = 0
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
        """Since the training began, without what was done after the checkpoint and lost."""
        return time.perf_counter() - self._start + (self.checkpoint.seconds if self.checkpoint else 0.0)


def begin_attempt(cell: Cell, folder: Path, environment: Mapping[str, Any], every: int) -> Attempt:
    """Go on from the checkpoint in a partial folder, or start over; which of the two is written into its log.

    Args:
        cell: To be trained.
        folder: Its partial folder; emptied, but for the log, where nothing in it is of use.
        environment: What the cell runs on now; see `harness.experiment.provenance.describe_environment`.
        every: Environment steps from one checkpoint to the next, at least; 0 for none.
    """
    origin = {"cell": cell.id, **{key: environment[key] for key in ("versions", "commit", "sources")}}
    checkpoint, note = None, ""
    if _left_behind(folder):
        try:
            checkpoint = read_checkpoint(folder, origin) if (folder / CHECKPOINT).is_file() else None
            reason = "no checkpoint was left"
        except SchemaError as error:
            reason = f"{CHECKPOINT} is of no use: {error}"
        note = f"went on after {checkpoint.steps} steps" if checkpoint else f"started over: {reason}"
        write_log(folder / LOG, f"an earlier process was killed; this one {note}")
    if not checkpoint:
        _empty(folder)
    for path in filter(is_partial, folder.iterdir()):
        path.unlink()  # half of a checkpoint that was being written
    return Attempt(folder, origin, every, checkpoint, note)


def _left_behind(folder: Path) -> list[Path]:
    """What an earlier process left beside the log."""
    return [path for path in folder.iterdir() if path.name != LOG]


def _empty(folder: Path) -> None:
    for path in _left_behind(folder):
        shutil.rmtree(path) if path.is_dir() else path.unlink()
