"""What a run writes down of the cells that it is doing, for who looks from another process: ``running.json``.

The file says nothing that lasts: it is not synced to the disk, and it is gone when the run has ended. A run that was
killed leaves it; `harness.record.store.Store.is_in_use` tells the two apart.
"""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import Field

from harness.errors import SchemaError
from harness.files.bounded import read_json, reading, whole_files
from harness.record.file_forms import Number, Seconds, Whole, read_form

RUNNING = "running.json"


@dataclass(frozen=True)
class Running:
    """A cell that is being done; times are seconds since 1970.

    Attributes:
        started: When it began.
        steps: Environment steps done.
        told: When it told so.
        success: Share of its last episodes that reached the target; None before the first has ended.
        mean_return: What they were paid on average.
        track: When it was begun that trackers follow, as they were told: earlier than `started` of a cell that goes on
            after a kill. 0 before trackers know of it.
        tracked: Environment steps of which trackers were told.
    """

    started: Seconds
    steps: Whole = 0
    told: Seconds = 0.0
    success: Annotated[float, Field(ge=0, le=1)] | None = None
    mean_return: Number | None = None
    track: Seconds = 0.0
    tracked: Whole = 0

    def after(self, steps: int, now: float, **shown: Any) -> Self:
        """The same cell, when it has told its steps, and its success and return if they are given."""
        return replace(self, steps=max(steps, self.steps), told=now, **shown)


def write_running(folder: Path, running: Mapping[str, Running]) -> None:
    """Write down the running cells of the experiment in `folder`, by id."""
    content = json.dumps({cell: asdict(one) for cell, one in running.items()})
    with whole_files(folder, [RUNNING], is_lasting=False) as (partial,):
        partial.write_text(content)


def read_running(folder: Path) -> dict[str, Running]:
    """The cells of the experiment in `folder` that a run is doing, or was when it was killed, by id.

    Raises:
        SchemaError: The file is damaged.
    """
    path = folder / RUNNING
    if not path.exists():
        return {}
    with reading(path, "account of running cells"):
        return read_form(dict[str, Running], read_json(path))


def read_left(folder: Path) -> dict[str, Running]:
    """The same, for the run that begins after a kill: where the file is damaged, nothing is known."""
    try:
        return read_running(folder)
    except SchemaError:
        return {}
