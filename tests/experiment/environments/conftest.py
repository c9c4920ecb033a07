"""Toys that several tests train in."""

from pathlib import Path

import pytest

from harness.registry import load_registry, read_given

FOLDER = Path(__file__).parent


@pytest.fixture(scope="module")
def given():
    """A toy with goals, and one without."""
    return read_given([FOLDER / "goal_toy.py", FOLDER / "toy.py"])


@pytest.fixture(scope="module")
def registry(given):
    """The installed plugins and the toys."""
    return load_registry(given=given)
