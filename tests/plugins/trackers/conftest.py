"""What tests of trackers share."""

import pytest

from harness.experiment.followed import tracked_cell


@pytest.fixture
def tracked(make_cell, tmp_path, monkeypatch):
    """A cell of an experiment in an empty folder, which is the working directory."""
    monkeypatch.chdir(tmp_path)
    return tracked_cell(make_cell(), 1000.0, tmp_path)
