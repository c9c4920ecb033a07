"""Files that are there completely or not at all."""

import os
from pathlib import Path

import pytest

import harness.files.bounded
from harness.files.bounded import is_partial, whole_file, whole_files, write_whole


def test_file_takes_the_place_of_the_old_one(tmp_path):
    """Nothing else is left beside it."""
    path = tmp_path / "plan.json"
    path.write_text("old")
    write_whole(path, "new \u03b7")
    assert path.read_text() == "new \u03b7"
    assert list(tmp_path.iterdir()) == [path]


def test_interrupted_write_leaves_the_old_file(tmp_path):
    """Whatever passes, KeyboardInterrupt too; the half-written file is gone."""
    path = tmp_path / "plan.json"
    path.write_text("old")

    def write():
        with whole_file(path) as partial:
            partial.write_text("ne")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_half_written_file_is_known_by_its_name(tmp_path):
    """A process that is killed leaves one: who looks into the folder passes it over."""
    with whole_file(tmp_path / "plan.json") as partial:
        partial.touch()
        assert is_partial(partial)
    assert not is_partial(tmp_path / "plan.json")


def test_bytes_are_on_the_disk_before_the_name_and_the_name_before_it_ends(tmp_path, monkeypatch):
    """A machine that stops leaves the old file or the new one."""
    done = []
    replace = os.replace
    monkeypatch.setattr(os, "fsync", lambda number: done.append(os.fstat(number).st_ino))
    monkeypatch.setattr(os, "replace", lambda old, new: (done.append("renamed"), replace(old, new)))
    path = tmp_path / "plan.json"
    write_whole(path, "new")
    assert done == [path.stat().st_ino, "renamed", tmp_path.stat().st_ino]


@pytest.fixture
def synced(monkeypatch):
    """Names of the files and folders that the disk was asked for, in order."""
    names = []
    monkeypatch.setattr(harness.files.bounded, "sync", lambda path: names.append(path.name))
    return names


def write_both(folder, is_lasting=True):
    """Two files at once."""
    with whole_files(folder, ["a", "b"], is_lasting) as partials:
        for partial in partials:
            partial.write_text("new")


def test_several_files_take_their_places(tmp_path, synced):
    """All of them are on the disk before the first has its name, and the folder is asked for once."""
    write_both(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "b"]
    assert len(synced) == 3
    assert all(is_partial(Path(name)) for name in synced[:2])
    assert synced[2] == tmp_path.name


def test_no_file_takes_its_place_before_all_are_written(tmp_path):
    """An exception leaves the old ones, and nothing beside them."""
    (tmp_path / "a").write_text("old")

    def write():
        with whole_files(tmp_path, ["a", "b"]) as (first, _):
            first.write_text("new")
            raise OSError

    with pytest.raises(OSError):  # noqa: PT011 (which one is no matter)
        write()
    assert (tmp_path / "a").read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def test_what_need_not_last_does_not_wait_for_the_disk(tmp_path, synced):
    """It is whole nevertheless."""
    write_both(tmp_path, is_lasting=False)
    assert not synced
    assert (tmp_path / "b").read_text() == "new"
