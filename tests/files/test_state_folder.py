"""Where the harness remembers what belongs to a user."""

from pathlib import Path

import pytest

from harness.files.state_folder import STATE, state_folder


@pytest.mark.parametrize("told", ["", "relative/folder"])
def test_without_a_whole_path_it_is_below_the_home_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, told: str):
    """The standard says to ignore relative ones."""
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv(STATE, told)
    assert state_folder() == tmp_path / ".local" / "state" / "fd100-harness"


def test_a_folder_that_is_named_is_taken(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    """As for any program."""
    monkeypatch.setenv(STATE, str(tmp_path))
    assert state_folder() == tmp_path / "fd100-harness"
