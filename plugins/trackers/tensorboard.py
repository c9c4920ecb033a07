"""Event files that TensorBoard reads."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from harness.executor import Outcome, TrackedCell

if TYPE_CHECKING:
    from tensorboard.summary import Writer

LONGEST = 100
"""The largest number of characters that a folder's name takes from the title of its cell."""


@dataclass(frozen=True)
class TensorBoard:
    """Event files in ``tensorboard/`` of the experiment's folder, a folder for each cell."""

    folder: ClassVar[str] = "tensorboard"

    def why_not(self) -> str:
        return ""

    def begin(self, cell: TrackedCell) -> "Events":
        from tensorboard import summary  # it takes a second

        title = re.sub(r"[^\w.,=+-]+", "_", cell.title)[:LONGEST]
        return Events(summary.Writer(str(cell.folder / self.folder / f"{title}-{cell.id}")))


class Events:
    """The event files of one cell. A cell that goes on adds a file to them."""

    def __init__(self, writer: "Writer") -> None:
        self._writer = writer

    def log(self, steps: int, scalars: Mapping[str, float]) -> None:
        with np.errstate(over="ignore"):  # it keeps float32: what is too large becomes infinite
            for name, value in scalars.items():
                self._writer.add_scalar(name, value, steps)
        self._writer.flush()  # so that TensorBoard shows it now

    def end(self, outcome: Outcome, reason: str) -> None:
        self._writer.close()
