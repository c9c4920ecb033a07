"""Files that say themselves whether they are whole, and whose they are."""

import os
from pathlib import Path

import pytest

from harness.files.keyed_file import is_whole, read_keyed, write_keyed
from harness.files.machine_key import machine_key

CONTENT = bytes(range(256)) * 4


@pytest.fixture(name="file")
def _file(tmp_path: Path) -> Path:
    write_keyed(tmp_path / "it", "mine", CONTENT)
    return tmp_path / "it"


def test_content_comes_back(file: Path):
    """Under its key, byte for byte."""
    assert read_keyed(file, "mine", 2**20) == CONTENT


def test_other_key_gives_nothing(file: Path):
    """A file that was copied under another name is not what that name promises."""
    assert read_keyed(file, "yours", 2**20) is None
    assert is_whole(file, 2**20)


@pytest.mark.parametrize("at", [0, 64, 65, 500, -1])
def test_damaged_byte_gives_nothing(file: Path, at: int):
    """Wherever it is, in the first line too."""
    content = bytearray(file.read_bytes())
    content[at] ^= 1
    file.write_bytes(content)
    assert read_keyed(file, "mine", 2**20) is None
    assert not is_whole(file, 2**20)


@pytest.mark.parametrize("left", [0, 10, 65, 700])
def test_shortened_file_gives_nothing(file: Path, left: int):
    """As a machine may leave it that stopped."""
    file.write_bytes(file.read_bytes()[:left])
    assert read_keyed(file, "mine", 2**20) is None


def test_file_that_is_too_large_gives_nothing(file: Path):
    """It is not read."""
    assert read_keyed(file, "mine", 100) is None


def test_missing_file_gives_nothing(tmp_path: Path):
    """Whoever asks makes it."""
    assert read_keyed(tmp_path / "none", "mine", 2**20) is None


def test_writing_waits_for_no_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """What a stopped machine leaves of it is found damaged, and made again."""

    def wait(number: int) -> None:
        raise AssertionError("it was synced")

    monkeypatch.setattr(os, "fsync", wait)
    write_keyed(tmp_path / "it", "mine", CONTENT)
    assert read_keyed(tmp_path / "it", "mine", 2**20) == CONTENT


def test_what_another_machine_wrote_gives_nothing(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """It is whole, under the right key, with the right digest: anybody can write such a file."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "another"))
    machine_key.cache_clear()
    try:
        assert is_whole(file, 2**20)
        assert read_keyed(file, "mine", 2**20) is None
    finally:
        monkeypatch.undo()
        machine_key.cache_clear()
    assert read_keyed(file, "mine", 2**20) == CONTENT
