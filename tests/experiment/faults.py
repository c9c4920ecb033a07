"""Faults of the system, injected at one chosen write: the disk is full, fails, or too many files are open."""

import os
import sys
from contextlib import contextmanager

import pyarrow.parquet as pq
import pytest
import safetensors.numpy

WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC
CHANGES = ("os.mkdir", "os.rename", "os.remove", "os.rmdir", "os.truncate")


class Faults:
    """Counts everything that changes the disk below a folder; lets one of them go wrong.

    Attributes:
        count: Changes so far.
    """

    def __init__(self) -> None:
        self.count, self._at, self._fault = 0, -1, lambda: None
        self._folder: str | None = None
        sys.addaudithook(self._hear)  # it cannot be taken away again: it is deaf unless it is armed

    @contextmanager
    def armed(self, folder, at=-1, fault=lambda: None):
        """Within this, change number `at`, counted from 0, calls `fault` before it happens."""
        self.count, self._at, self._fault, self._folder = 0, at, fault, str(folder)
        try:
            yield
        finally:
            self._folder = None

    def meet(self, path):
        """Something is about to change."""
        if self._folder is None or not str(path).startswith(self._folder):
            return
        self.count += 1
        if self.count - 1 == self._at:
            self._fault()

    def _hear(self, event, given):
        if self._folder is None:
            return
        if event in CHANGES or (event == "open" and isinstance(given[2], int) and given[2] & WRITES):
            self.meet(os.fsdecode(given[0]) if isinstance(given[0], str | bytes | os.PathLike) else "")


FAULTS = Faults()


@pytest.fixture
def faults(monkeypatch):
    """What Python tells of by itself, and what libraries write behind its back."""
    for owner, name in ((pq.ParquetWriter, "__init__"), (safetensors.numpy, "save_file")):
        _meet_first(monkeypatch, owner, name, place=1)
    for name in ("write_table", "close"):
        _meet_first(monkeypatch, pq.ParquetWriter, name, place=None)
    _meet_first(monkeypatch, os, "fsync", place=None)
    return FAULTS


def _meet_first(monkeypatch, owner, name, place):
    """Have a function count as a change of the file in its argument number `place`, or of the folder."""
    original = getattr(owner, name)

    def met(*args, **options):
        FAULTS.meet(args[place] if place is not None else FAULTS._folder)
        return original(*args, **options)

    monkeypatch.setattr(owner, name, met)
