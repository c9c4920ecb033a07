"""Whether a cell's folder still is what was left there."""

import os
from pathlib import Path

import pytest

from harness.errors import NewerFormat
from harness.files.sealed import seal, unseal
from harness.record import LOG, MANIFEST, TRACE, Manifest, Store, read_manifest


@pytest.fixture
def examined(make_cell, tmp_path):
    """What is said of a cell."""
    return lambda: Store(tmp_path).examine(make_cell())


@pytest.fixture
def folder(make_cell, tmp_path):
    """Of a done cell."""
    folder = Store(tmp_path).cell_folder(make_cell())
    folder.mkdir(parents=True)
    (folder / TRACE).write_bytes(b"rows")
    (folder / LOG).write_text("said\n")
    Manifest(make_cell(), status="done").write(folder)
    return folder


def test_sound_cell_is_what_its_manifest_says(examined, folder):
    """Its digests included."""
    assert examined() == read_manifest(folder)
    assert read_manifest(folder).files.keys() == {TRACE, LOG}


def test_cell_without_a_folder_is_pending(examined):
    """It was never run."""
    assert examined().status == "pending"


def _link(path):
    path.rename(path.with_name("other"))
    path.symlink_to(path.with_name("other"))


def _name_no_files(path):
    path.write_bytes(seal({key: value for key, value in unseal(path.read_bytes()).items() if key != "files"}))


def _pipe(path):
    path.unlink()
    os.mkfifo(path)


DAMAGES = {
    "changed": (TRACE, lambda path: path.write_bytes(b"Rows"), "is not what was written: its SHA-256 differs"),
    "missing": (TRACE, Path.unlink, "is missing"),
    "a link": (TRACE, _link, "is a link"),
    "a pipe": (TRACE, _pipe, "is missing"),
    "changed log": (LOG, lambda path: path.write_text("Said\n"), "is not what was written"),
    "cut manifest": (MANIFEST, lambda path: path.write_bytes(path.read_bytes()[:50]), "is no readable manifest"),
    "manifest without digests": (MANIFEST, _name_no_files, "files"),
    "no manifest": (MANIFEST, Path.unlink, "is no readable manifest"),
    "manifest that is a pipe": (MANIFEST, _pipe, "it is no regular file"),
}


@pytest.mark.parametrize(("name", "damage", "message"), DAMAGES.values(), ids=DAMAGES)
def test_damage_is_told(make_cell, examined, folder, name, damage, message):
    """Which file, what is wrong, what to do."""
    damage(folder / name)
    found = examined()
    assert (found.status, found.cell) == ("damaged", make_cell())
    assert f"{folder / name}" in found.reason
    assert message in found.reason
    assert found.reason.endswith("; run again to replace it")


def test_cell_of_a_newer_version_is_no_damage(examined, folder):
    """Nothing may replace it."""
    (folder / MANIFEST).write_text('{"format": 3}')
    with pytest.raises(NewerFormat, match="has format 3"):
        examined()
