"""Files that are there completely or not at all."""

import os
from pathlib import Path

import pytest

from harness.files.whole_file import is_partial, whole_file, write_whole


def test_file_takes_the_place_of_the_old_one(tmp_path: Path):
    """Nothing else is left beside it."""
    path = tmp_path / "plan.json"
    path.write_text("old")
    write_whole(path, "new \u03b7")
    assert path.read_text(encoding="utf-8") == "new \u03b7"
    assert list(tmp_path.iterdir()) == [path]


def test_interrupted_write_leaves_the_old_file(tmp_path: Path):
    """Whatever passes, KeyboardInterrupt too; the half-written file is gone."""
    path = tmp_path / "plan.json"
    path.write_text("old")

    def write() -> None:
        with whole_file(path) as partial:
            partial.write_text("ne")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_half_written_file_is_known_by_its_name(tmp_path: Path):
    """A process that is killed leaves one: who looks into the folder passes it over."""
    with whole_file(tmp_path / "plan.json") as partial:
        partial.touch()
        assert is_partial(partial)
    assert not is_partial(tmp_path / "plan.json")


@pytest.mark.parametrize("synced", [True, False])
def test_bytes_are_on_the_disk_before_the_name_and_the_name_before_it_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, synced: bool
):
    """A machine that stops leaves the old file or the new one; a file that is not synced waits for no disk."""
    done: list[object] = []
    replace = os.replace
    monkeypatch.setattr(os, "fsync", lambda number: done.append(os.fstat(number).st_ino))
    monkeypatch.setattr(os, "replace", lambda old, new: (done.append("renamed"), replace(old, new)))
    path = tmp_path / "plan.json"
    write_whole(path, "new", synced=synced)
    assert done == ([path.stat().st_ino, "renamed", tmp_path.stat().st_ino] if synced else ["renamed"])
