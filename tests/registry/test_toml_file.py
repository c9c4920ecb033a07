"""A file of keys and values."""

from pathlib import Path

import pytest

from harness.errors import UsageError
from harness.registry.toml_file import read_toml


def test_an_override_wins_over_the_file(tmp_path: Path):
    """A key that is given beside the file has the value that was given."""
    (tmp_path / "a.toml").write_text("x = 1\ny = 2\n")
    assert read_toml(tmp_path / "a.toml", "experiment file", {"y": 3}) == {"x": 1, "y": 3}


def test_a_missing_file_is_named(tmp_path: Path):
    """The message has the path."""
    with pytest.raises(UsageError, match=r"No experiment file '.*a\.toml'"):
        read_toml(tmp_path / "a.toml", "experiment file")


@pytest.mark.parametrize("content", [b"x = ", b"\xff\xfe", None], ids=["no TOML", "no UTF-8", "a folder"])
def test_a_file_that_cannot_be_read_is_named(tmp_path: Path, content: bytes | None):
    """No TOML, no text, no file: one line each, which begins with what it is and ends with what to do."""
    path = tmp_path / "a.toml"
    path.mkdir() if content is None else path.write_bytes(content)
    with pytest.raises(
        UsageError, match=r"^Experiment file '.*a\.toml' cannot be read: .*\. Give a TOML file in UTF-8\.$"
    ):
        read_toml(path, "experiment file")
