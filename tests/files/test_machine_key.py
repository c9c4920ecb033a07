"""The key of this user on this machine."""

import os
import stat
from collections.abc import Iterator
from pathlib import Path

import pytest

from harness.files.machine_key import SIZE, key_file, machine_key


@pytest.fixture(autouse=True)
def state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A new home for the state of programs."""
    machine_key.cache_clear()
    with monkeypatch.context() as patch:
        patch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
        yield tmp_path / "state"
    machine_key.cache_clear()


def _again() -> bytes:
    machine_key.cache_clear()
    return machine_key()


def test_another_process_has_the_same():
    """It is kept."""
    first = machine_key()
    assert len(first) == SIZE
    assert _again() == first


@pytest.mark.skipif(os.name != "posix", reason="rights of files are POSIX's")
def test_nobody_else_reads_it():
    """Nor the folder in which it lies."""
    machine_key()
    assert stat.S_IMODE(key_file().stat().st_mode) == 0o600
    assert stat.S_IMODE(key_file().parent.stat().st_mode) == 0o700


@pytest.mark.skipif(os.name != "posix", reason="rights of files are POSIX's")
def test_one_that_others_may_read_is_not_used():
    """Each process then has one of its own, and believes nothing that others kept."""
    first = machine_key()
    key_file().chmod(0o644)
    assert _again() != first
    assert _again() != _again()


@pytest.mark.parametrize("content", [b"", b"short", b"x" * 33])
def test_what_is_no_key_is_not_used(content: bytes):
    """And stays as it is."""
    machine_key()
    key_file().write_bytes(content)
    assert _again() != _again()
    assert key_file().read_bytes() == content


def test_a_link_is_not_followed(tmp_path: Path):
    """Somebody else may know what it leads to."""
    known = tmp_path / "known"
    known.write_bytes(b"k" * SIZE)
    known.chmod(0o600)
    key_file().parent.mkdir(parents=True)
    key_file().symlink_to(known)
    assert _again() != b"k" * SIZE


def test_where_none_can_be_kept_a_process_has_its_own(state: Path):
    """Reports work, and keep nothing for the next one."""
    state.write_text("a file in the place of the folder")
    assert len(_again()) == SIZE
    assert _again() != _again()
