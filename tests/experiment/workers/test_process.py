"""How processes of workers are started."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from harness.experiment.workers import workers as worker_process


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """Commands that would have been started."""
    commands: list[list[str]] = []

    def note(command: list[str], **options: Any) -> None:
        commands.append(command)

    monkeypatch.setattr(subprocess, "Popen", note)
    return commands


def test_worker_imports_nothing_from_the_working_directory(
    started: list[list[str]], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
):
    """A folder there may be called as a package that a cell needs."""
    monkeypatch.chdir(tmp_path)
    worker_process._start({})
    assert started == [[sys.executable, "-P", "-m", "harness.experiment.workers.worker"]]


def test_worker_imports_from_where_its_parent_does(started: list[list[str]], monkeypatch: pytest.MonkeyPatch):
    """As ``python -m harness`` does it in a checkout that is not installed."""
    monkeypatch.setattr(sys, "path", [os.getcwd(), *sys.path])
    worker_process._start({})
    assert started == [[sys.executable, "-m", "harness.experiment.workers.worker"]]
