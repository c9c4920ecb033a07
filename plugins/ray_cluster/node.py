"""What runs on a node of the cluster."""

import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, NamedTuple, TypeAlias

from harness.executor import Cell, Job, Part, Word, add_parts, parts_of
from harness.experiment.installation import describe_workers
from harness.experiment.jobs import order_of
from harness.experiment.workers.workers import Pool
from harness.record.folder import partial_folder
from harness.registry.given import Given

TELL_EVERY: Final = 0.5
"""Seconds between two reports of progress."""
KILLED: Final = (-signal.SIGTERM, -9)
"""The exit statuses of a process that did not fail by itself. Windows has no name for the second signal."""


class Ended(NamedTuple):
    """The last news of a cell."""

    reason: str
    """Why it left no folder; empty if it did."""
    is_killed: bool = False
    """Whether somebody killed its process, as a system does that runs out of memory: it is worth another try."""


Told: TypeAlias = Word | Part | Ended
"""News of a cell: how far it is, some of its files, or its end."""


class Found(NamedTuple):
    """What a node has for the cells of a run."""

    installed: dict[str, str]
    """See `describe_workers`."""
    sees_folder: bool
    """Whether it can write where the cells' folders have to be."""


def look_around(cells: Sequence[Mapping[str, Any]], token: str, plugins: Sequence[Given]) -> Found:
    """What this node has for some cells.

    Args:
        cells: The cells, as JSON. Their plugins matter.
        token: A file that is in the experiment's folder.
        plugins: Plugins that the user gave by hand.
    """
    installed = describe_workers(map(Cell.from_json, cells), plugins)
    return Found(installed, Path(token).is_file())


class Slot:
    """A Ray actor that does one cell after the other, each in a process of its node."""

    def __init__(self) -> None:
        self._pool = Pool()

    def ready(self) -> None:
        """Return as soon as the slot has its place on a node."""

    def do(self, told: Mapping[str, Any], command: list[str]) -> Iterator[Told]:
        """Do a job in its own folder, which this node sees.

        Args:
            told: The job, by `Job.to_json`.
            command: What the user typed.
        """
        yield from self._do(Job.from_json(told), command)

    def do_and_send(self, told: Mapping[str, Any], command: list[str], left: list[Part]) -> Iterator[Told]:
        """Do a job in a folder of this node, and send the files that it leaves, before the news of its end.

        Args:
            told: The job, by `Job.to_json`.
            command: What the user typed.
            left: What an earlier process left in the job's partial folder.
        """
        job, place = Job.from_json(told), Path(tempfile.mkdtemp(prefix="harness-"))
        try:
            folder = place / job.folder.name
            add_parts(partial_folder(folder), left)
            for news in self._do(replace(job, folder=folder), command):
                if isinstance(news, Ended):
                    yield from parts_of(partial_folder(folder) if news.reason else folder)
                yield news
        finally:
            shutil.rmtree(place, ignore_errors=True)

    def _do(self, job: Job, command: list[str]) -> Iterator[Told]:
        sys.argv = command  # the manifest records it
        told_last = 0.0
        for news in self._pool.run([order_of(job)], 1):
            if news.kind == "ended":
                yield Ended(news.reason, news.status in KILLED and not news.over_limit)
            elif news.kind == "progress" and (news.scalars or time.monotonic() - told_last >= TELL_EVERY):
                told_last = time.monotonic()
                yield Word(news.steps, news.scalars)
