"""What tests of trackers share."""

from collections.abc import Callable
from pathlib import Path

import pytest

from harness.experiment.progress.trackers import tracked_cell
from harness.record.cell import Cell
from harness.tracker import TrackedCell


@pytest.fixture
def tracked(make_cell: Callable[..., Cell], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> TrackedCell:
    """A cell of an experiment in an empty folder, which is the working directory."""
    monkeypatch.chdir(tmp_path)
    return tracked_cell(make_cell(), 1000.0, tmp_path)
