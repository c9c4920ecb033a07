"""Reading files that anybody may have made."""

import os
from pathlib import Path

import h5py
import pytest

from harness.errors import SchemaError, UsageError
from harness.files import open_regular, reading
from harness.files.bounded import digest_of, read_json, read_text
from tests.refusals import refused


def test_regular_file_is_read(tmp_path):
    """A link to one is followed: the user may lay his files where he likes."""
    (tmp_path / "a").write_text("\u03b7")
    (tmp_path / "b").symlink_to(tmp_path / "a")
    assert read_text(tmp_path / "b") == "\u03b7"


def test_large_file_is_refused_unread(tmp_path):
    """A sparse one takes no space, and would take all memory."""
    with (tmp_path / "a").open("wb") as file:
        file.truncate(2**40)
    with pytest.raises(OSError, match="it has 1,099,511,627,776 bytes, 16,777,216 are allowed"):
        read_text(tmp_path / "a")


def test_pipe_is_refused(tmp_path):
    """It would hang."""
    os.mkfifo(tmp_path / "a")
    with pytest.raises(OSError, match="no regular file"):
        read_text(tmp_path / "a")


def test_device_is_refused():
    """It never ends."""
    with pytest.raises(OSError, match="no regular file"), open_regular(Path("/dev/zero"), 10):
        pass


def test_folder_is_refused(tmp_path):
    """It is no file."""
    with pytest.raises(OSError, match=r"directory|no regular file"):
        read_text(tmp_path)


def test_what_is_no_json_is_refused(tmp_path_factory, subtests):
    """ValueError, whatever the parser raises."""
    for text in ["[" * 100_000, "NaN", "[Infinity]", "[1e999]", "{", "1" * 10_000]:
        with subtests.test(text=text):
            tmp_path = tmp_path_factory.mktemp("case")
            (tmp_path / "a").write_text(text)
            with pytest.raises(ValueError, match=r"."):
                read_json(tmp_path / "a")


@pytest.mark.parametrize("error", [RecursionError("deep"), OverflowError(), KeyError("x"), MemoryError()], ids=repr)
def test_whatever_a_reader_raises_is_one_line(tmp_path, error):
    """It names the file and what it should be."""
    with pytest.raises(SchemaError, match=rf"{tmp_path} is no readable mesh: {type(error).__name__}"):  # noqa: SIM117
        with reading(tmp_path, "mesh"):
            raise error


@pytest.mark.parametrize(("made", "told"), [(True, "it is empty"), (False, "there is no such file")])
def test_what_is_empty_or_missing_is_said_to_be(tmp_path, made, told):
    """Whatever a library says of it."""
    if made:
        (tmp_path / "a").touch()
    with refused(f"a is no readable mesh: {told}"), reading(tmp_path / "a", "mesh", UsageError):
        raise ValueError("cannot mmap an empty file")


def test_reader_of_what_a_user_named_raises_a_usage_error(tmp_path):
    """The caller says so."""
    with refused("no readable robot"), reading(tmp_path, "robot", UsageError):
        raise KeyError


def test_our_own_errors_pass(tmp_path):
    """They say more."""
    with refused("mine"), reading(tmp_path, "mesh"):
        raise UsageError("mine")


def test_digest_is_sha256(tmp_path):
    """As `sha256sum` prints it."""
    (tmp_path / "a").write_bytes(b"abc")
    assert digest_of(tmp_path / "a") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"


def test_a_file_that_is_what_it_should_be_is_told_what_is_wrong(tmp_path):
    """Not that it is what the reader expected."""
    path = tmp_path / "demos"
    with h5py.File(path, "w") as file:
        file["data/demo_0/actions"] = [1.0]
    with pytest.raises(SchemaError, match="no readable robomimic data set: KeyError: 'rewards'"):  # noqa: SIM117
        with reading(path, "robomimic data set"):
            raise KeyError("rewards")
    with pytest.raises(SchemaError, match="no readable table: it is a robomimic data set in HDF5"):  # noqa: SIM117
        with reading(path, "table"):
            raise ValueError("no text")
