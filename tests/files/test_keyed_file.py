"""Files that say themselves whether they are whole, and whose they are."""

import os
import stat

import pytest

from harness.files.bounded import SIZE, STATE, is_whole, key_file, machine_key, read_keyed, state_folder, write_keyed

CONTENT = bytes(range(256)) * 4


@pytest.fixture(name="file")
def _file(tmp_path):
    write_keyed(tmp_path / "it", "mine", CONTENT)
    return tmp_path / "it"


def test_content_comes_back(file):
    """Under its key, byte for byte."""
    assert read_keyed(file, "mine", 2**20) == CONTENT


def test_other_key_gives_nothing(file):
    """A file that was copied under another name is not what that name promises."""
    assert read_keyed(file, "yours", 2**20) is None
    assert is_whole(file, 2**20)


@pytest.mark.parametrize("at", [0, 64, 65, 500, -1])
def test_damaged_byte_gives_nothing(file, at):
    """Wherever it is, in the first line too."""
    content = bytearray(file.read_bytes())
    content[at] ^= 1
    file.write_bytes(content)
    assert read_keyed(file, "mine", 2**20) is None
    assert not is_whole(file, 2**20)


@pytest.mark.parametrize("left", [0, 10, 65, 700])
def test_shortened_file_gives_nothing(file, left):
    """As a machine may leave it that stopped."""
    file.write_bytes(file.read_bytes()[:left])
    assert read_keyed(file, "mine", 2**20) is None


def test_file_that_is_too_large_gives_nothing(file):
    """It is not read."""
    assert read_keyed(file, "mine", 100) is None


def test_missing_file_gives_nothing(tmp_path):
    """Whoever asks makes it."""
    assert read_keyed(tmp_path / "none", "mine", 2**20) is None


def test_writing_waits_for_no_disk(tmp_path, monkeypatch):
    """What a stopped machine leaves of it is found damaged, and made again."""

    def wait(number):
        raise AssertionError("it was synced")

    monkeypatch.setattr(os, "fsync", wait)
    write_keyed(tmp_path / "it", "mine", CONTENT)
    assert read_keyed(tmp_path / "it", "mine", 2**20) == CONTENT


def test_what_another_machine_wrote_gives_nothing(file, tmp_path, monkeypatch):
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


@pytest.fixture(autouse=True)
def state(tmp_path, monkeypatch):
    """A new home for the state of programs."""
    machine_key.cache_clear()
    with monkeypatch.context() as patch:
        patch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
        yield tmp_path / "state"
    machine_key.cache_clear()


def _again():
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
def test_what_is_no_key_is_not_used(content):
    """And stays as it is."""
    machine_key()
    key_file().write_bytes(content)
    assert _again() != _again()
    assert key_file().read_bytes() == content


def test_a_link_is_not_followed(tmp_path):
    """Somebody else may know what it leads to."""
    known = tmp_path / "known"
    known.write_bytes(b"k" * SIZE)
    known.chmod(0o600)
    key_file().parent.mkdir(parents=True)
    key_file().symlink_to(known)
    assert _again() != b"k" * SIZE


def test_where_none_can_be_kept_a_process_has_its_own(state):
    """Reports work, and keep nothing for the next one."""
    state.write_text("a file in the place of the folder")
    assert len(_again()) == SIZE
    assert _again() != _again()


@pytest.mark.parametrize("told", ["", "relative/folder"])
def test_without_a_whole_path_it_is_below_the_home_folder(monkeypatch, tmp_path, told):
    """The standard says to ignore relative ones."""
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv(STATE, told)
    assert state_folder() == tmp_path / ".local" / "state" / "fd100-harness"


def test_a_folder_that_is_named_is_taken(monkeypatch, tmp_path):
    """As for any program."""
    monkeypatch.setenv(STATE, str(tmp_path))
    assert state_folder() == tmp_path / "fd100-harness"
