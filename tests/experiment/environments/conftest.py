"""Toys that several tests train in."""

from pathlib import Path

import pytest

from harness.registry.given import Given, read_given
from harness.registry.registry import Registry, load_registry

FOLDER = Path(__file__).parent


@pytest.fixture(scope="module")
def given() -> tuple[Given, ...]:
    """A toy with goals, and one without."""
    return read_given([FOLDER / "goal_toy.py", FOLDER / "toy.py"])


@pytest.fixture(scope="module")
def registry(given: tuple[Given, ...]) -> Registry:
    """The installed plugins and the toys."""
    return load_registry(given=given)
