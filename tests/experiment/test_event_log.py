"""Scalars in event files."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from harness.errors import UsageError
from harness.experiment.event_log import EventLog, require_tensorboard


def test_written_scalars_are_read_back(tmp_path: Path, read_events: Callable):
    """By name, with their steps, also where one folder is written twice, as by a cell that was resumed."""
    for steps in (100, 200):
        with EventLog(tmp_path / "tensorboard") as events:
            events.write(steps, {"Losses/Policy Loss": 0.5, "Policy/Entropy": float(steps)})
    found = read_events(tmp_path / "tensorboard")
    assert found == {
        "Losses/Policy Loss": [(100, 0.5), (200, 0.5)],
        "Policy/Entropy": [(100, 100.0), (200, 200.0)],
    }


def test_scalars_are_there_before_the_end(tmp_path: Path, read_events: Callable):
    """Who looks on while a cell trains sees them."""
    with EventLog(tmp_path) as events:
        events.write(7, {"Policy/Entropy": 2.0})
        assert read_events(tmp_path) == {"Policy/Entropy": [(7, 2.0)]}


def test_without_a_folder_nothing_is_written_or_imported(tmp_path: Path):
    """The library is not even looked for."""
    code = (
        "import sys; from harness.experiment.event_log import EventLog\n"
        "with EventLog(None) as events: events.write(1, {'a': 1.0}); assert not events.is_open\n"
        "assert 'tensorboard' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_missing_library_is_told_with_its_extra(monkeypatch: pytest.MonkeyPatch):
    """One line, with what to install."""
    require_tensorboard()
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(UsageError, match=r"needs tensorboard: pip install 'fd100-harness\[tensorboard\]'"):
        require_tensorboard()
