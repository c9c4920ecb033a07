"""All processes that a worker started, whoever started them in between, and how they are ended."""

import os
import time
import uuid
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from typing import Final

import psutil

VARIABLE: Final = "HARNESS_OFFSPRING"
"""Environment variable that a process hands on to those that it starts."""
LONGEST: Final = 2.0
"""Seconds after which processes are left alone that do not end: the system holds them."""
LOOK_EVERY: Final = 0.02
"""Seconds between two looks for processes: while some are ended, others may start new ones."""


@dataclass(frozen=True)
class Offspring:
    """Processes with one mark in their environment. A process inherits it, also from one that has ended meanwhile.

    A process that was started with an environment of its own has no mark, and is not found.

    Attributes:
        mark: No other processes have it.
    """

    mark: str = field(default_factory=lambda: uuid.uuid4().hex)

    @property
    def environment(self) -> dict[str, str]:
        """What the first of them has to get."""
        return {VARIABLE: self.mark}

    def kill(self) -> None:
        """End all of them at once."""
        until = time.monotonic() + LONGEST
        while (found := list(self._living())) and time.monotonic() < until:
            for process in found:
                with suppress(psutil.Error):  # it has ended, or is another user's
                    process.kill()
            time.sleep(LOOK_EVERY)

    @contextmanager
    def ended_at_once(self) -> Iterator[None]:
        """If an exception passes, as after Ctrl-C, they are ended: nothing that they do is worth waiting for."""
        try:
            yield
        except BaseException:
            self.kill()
            raise

    def _living(self) -> Iterator[psutil.Process]:
        for process in psutil.process_iter():
            try:
                is_ours = process.pid != os.getpid() and process.environ().get(VARIABLE) == self.mark
                if is_ours and process.status() != psutil.STATUS_ZOMBIE:
                    yield process
            except (psutil.Error, OSError):  # it has ended, or is another user's
                continue
