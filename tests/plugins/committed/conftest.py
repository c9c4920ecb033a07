"""Summaries of small experiment folders."""

from collections.abc import Callable
from pathlib import Path

import pytest

from harness_plugins.committed.records import write_summary
from tests.report.conftest import barriers, build, driver, launch, mixed, show  # noqa: F401 -- fixtures


@pytest.fixture
def summarise(build: Callable, tmp_path: Path) -> Callable[..., Path]:  # noqa: F811
    """Builds an experiment, see `build`, and writes its summary into a folder of that name."""

    def write(name: str = "summary", **given: object) -> Path:
        write_summary(build(**given), tmp_path / name)
        return tmp_path / name

    return write
