"""Summaries of small experiment folders."""

from collections.abc import Callable
from pathlib import Path

import pytest

from harness.report.summary.summary import write_summary


@pytest.fixture
def summarise(build: Callable, tmp_path: Path) -> Callable[..., Path]:
    """Builds an experiment, see `build`, and writes its summary into a folder of that name."""

    def write(name: str = "summary", **given: object) -> Path:
        write_summary(build(**given), tmp_path / name)
        return tmp_path / name

    return write
