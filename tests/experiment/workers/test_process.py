"""How processes of workers are started."""

import os
import subprocess
import sys

import pytest

from harness.experiment.workers import workers as worker_process


@pytest.fixture
def started(monkeypatch):
    """Commands that would have been started."""
    commands = []

    def note(command, **options):
        commands.append(command)

    monkeypatch.setattr(subprocess, "Popen", note)
    return commands


def test_worker_imports_nothing_from_the_working_directory(started, monkeypatch, tmp_path):
    """A folder there may be called as a package that a cell needs."""
    monkeypatch.chdir(tmp_path)
    worker_process._start({})
    assert started == [[sys.executable, "-P", "-m", "harness.experiment.workers.worker"]]


def test_worker_imports_from_where_its_parent_does(started, monkeypatch):
    """As ``python -m harness`` does it in a checkout that is not installed."""
    monkeypatch.setattr(sys, "path", [os.getcwd(), *sys.path])
    worker_process._start({})
    assert started == [[sys.executable, "-m", "harness.experiment.workers.worker"]]
