"""What runs on a node of the cluster."""

import shutil
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple, TypeAlias

from harness.authoring.folder_parts import Part, add_parts, parts_of
from harness.executor import Job, Word
from harness.experiment.installation import describe_workers
from harness.experiment.jobs import events_of
from harness.experiment.workers.workers import Pool
from harness.record.cell import Cell
from harness.record.folder import partial_folder
from harness.registry.given import given_from_json

TELL_EVERY: Final = 0.5
"""Seconds from one word of progress to the next."""


class Ended(NamedTuple):
    """The last word about a cell."""

    reason: str
    """Why it left no folder; empty if it did."""


Told: TypeAlias = Word | Part | Ended
"""How far the cell is, some of the cell's files, or the end."""


class Found(NamedTuple):
    """What a node has."""

    installed: dict[str, str]
    """See `describe_workers`."""
    sees_folder: bool
    """Whether it can write where the cells' folders have to be."""


def look_around(cells: Sequence[Mapping[str, Any]], token: str, plugins: Sequence[Mapping[str, str]]) -> Found:
    """What this node has for some cells, told as JSON.

    Args:
        cells: Whose plugins matter.
        token: A file that is in the experiment's folder.
        plugins: Given by hand, told as JSON.
    """
    installed = describe_workers(map(Cell.from_json, cells), given_from_json(plugins))
    return Found(installed, Path(token).is_file())


class Slot:
    """Does one cell after the other, each in a process of its node; a Ray actor."""

    def __init__(self) -> None:
        self._pool = Pool()

    def ready(self) -> None:
        """Answers when the slot has its place on a node."""

    def do(self, told: Mapping[str, Any], command: list[str]) -> Iterator[Told]:
        """Do a job in its own folder, which this node sees.

        Args:
            told: The job, by `Job.to_json`.
            command: What the user typed.
        """
        yield from self._do(Job.from_json(told), command)

    def do_and_send(self, told: Mapping[str, Any], command: list[str], left: list[Part]) -> Iterator[Told]:
        """Do a job in a folder of this node, and tell the files that it leaves, before its end.

        Args:
            told: The job, by `Job.to_json`.
            command: What the user typed.
            left: Of an earlier process: what is in the job's partial folder.
        """
        job, place = Job.from_json(told), Path(tempfile.mkdtemp(prefix="harness-"))
        try:
            folder = place / job.folder.name
            add_parts(partial_folder(folder), left)
            for news in self._do(job._replace(folder=folder), command):
                if isinstance(news, Ended):
                    yield from parts_of(partial_folder(folder) if news.reason else folder)
                yield news
        finally:
            shutil.rmtree(place, ignore_errors=True)

    def _do(self, job: Job, command: list[str]) -> Iterator[Told]:
        sys.argv = command  # the manifest records it
        told_last = 0.0
        for event in events_of([job], 1, self._pool):
            if event.kind == "ended":
                yield Ended(event.reason)
            elif event.kind == "progress" and (event.scalars or time.monotonic() - told_last >= TELL_EVERY):
                told_last = time.monotonic()
                yield Word(event.steps, event.scalars)
