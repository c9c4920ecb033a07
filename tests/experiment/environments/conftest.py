"""Toys that several tests train in."""

from pathlib import Path

import pytest

from harness import load_registry
from harness.cli import main
from harness.registry import read_given

FOLDER = Path(__file__).parent


@pytest.fixture(scope="module")
def given():
    """A toy with goals, and one without."""
    return read_given([FOLDER / "goal_toy.py", FOLDER / "toy.py"])


@pytest.fixture(scope="module")
def registry(given):
    """The installed plugins and the toys."""
    return load_registry(given=given)


@pytest.fixture
def say(capsys, monkeypatch):
    """A command; its status and what it says on standard output and on standard error, into a wide window."""
    monkeypatch.setenv("COLUMNS", "300")

    def run(*arguments):
        with pytest.raises(SystemExit) as ended:
            main([*map(str, arguments)])
        return int(ended.value.code or 0), *capsys.readouterr()

    return run
