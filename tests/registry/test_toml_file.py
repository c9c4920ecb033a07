"""A file of keys and values."""

import os

import pytest

from harness.errors import UsageError
from harness.registry import read_toml
from harness.registry.toml_file import MOST_BYTES, MOST_DEPTH


def test_an_override_wins_over_the_file(tmp_path):
    """A key that is given beside the file has the value that was given."""
    (tmp_path / "a.toml").write_text("x = 1\ny = 2\n")
    assert read_toml(tmp_path / "a.toml", "experiment file", {"y": 3}) == {"x": 1, "y": 3}


def test_a_missing_file_is_named(tmp_path):
    """The message has the path."""
    with pytest.raises(UsageError, match=r"No experiment file '.*a\.toml'"):
        read_toml(tmp_path / "a.toml", "experiment file")


@pytest.mark.parametrize("content", [b"x = ", b"\xff\xfe", None], ids=["no TOML", "no UTF-8", "a folder"])
def test_a_file_that_cannot_be_read_is_named(tmp_path, content):
    """No TOML, no text, no file: one line each, which begins with what it is and ends with what to do."""
    path = tmp_path / "a.toml"
    path.mkdir() if content is None else path.write_bytes(content)
    with pytest.raises(
        UsageError, match=r"^Experiment file '.*a\.toml' cannot be read: .*\. Give a TOML file in UTF-8\.$"
    ):
        read_toml(path, "experiment file")


def refuse(path):
    """The line that a file is refused with."""
    with pytest.raises(UsageError) as refused:
        read_toml(path, "robot file")
    assert str(path) in str(refused.value)
    return str(refused.value)


def test_a_large_file_is_not_opened(tmp_path):
    """A sparse file of 10 GB is refused at once."""
    path = tmp_path / "a.toml"
    with path.open("wb") as file:
        file.truncate(10**10)
    assert f"it has 10,000,000,000 bytes, {MOST_BYTES:,} are allowed" in refuse(path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes in the file system")
def test_a_pipe_is_refused(tmp_path):
    """Nobody writes to it: to read it would take forever."""
    os.mkfifo(tmp_path / "a.toml")
    assert "it is no regular file" in refuse(tmp_path / "a.toml")


@pytest.mark.parametrize(
    "text",
    [
        "x = " + "[" * 50_000,
        "x = " + "{a = " * 50_000,
        "a" + ".a" * 100_000 + " = 1",
        "[" + "'a' . " * 50_000 + "a]",
        "[a.a.a.a.a.a.a.a.a.a]\nb.b.b.b.b.b.b.b.b = [[[[1]]]]",
    ],
    ids=["lists", "tables", "key", "heading", "together"],
)
def test_deep_tables_are_refused_at_once(tmp_path, text):
    """Tomllib takes minutes over a key of 100,000 parts, and reaches the end of the stack in lists."""
    (tmp_path / "a.toml").write_text(text)
    assert f"nested too deeply, {MOST_DEPTH} within one another are allowed" in refuse(tmp_path / "a.toml")


def test_a_long_number_is_refused(tmp_path):
    """Python converts no more than 4,300 digits."""
    (tmp_path / "a.toml").write_text("x = " + "9" * 100_000)
    assert "4300 digits" in refuse(tmp_path / "a.toml")
