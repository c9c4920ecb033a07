"""What a cell says of itself, and whether its folder still is what was left there."""

import json
import os
import re
from pathlib import Path

import pytest

from harness.errors import NewerFormat, SchemaError
from harness.files.bounded import seal, unseal
from harness.record import LOG, MANIFEST, TRACE, Manifest, Store, read_manifest


def test_manifest_is_read_as_it_was_written(make_cell, tmp_path):
    """Every field comes back; the file tells its format and the cell's id to other programs."""
    told = {"status": "failed", "reason": "no luck", "started": "2026-01-01T00:00:00+00:00", "seconds": 1.5}
    manifest = Manifest(make_cell(), 0.25, 6, "went on", **told, environment={"versions": {"numpy": "2"}})
    manifest.write(tmp_path)
    assert read_manifest(tmp_path) == manifest
    data = json.loads((tmp_path / MANIFEST).read_text())
    assert (data["format"], data["id"]) == (Manifest.FORMAT, make_cell().id)


@pytest.mark.parametrize("told", [{"error": "pose error", "unit": "m"}, {}])
def test_manifest_tells_the_error_of_a_goal(make_cell, tmp_path, told):
    """Its name and unit; of a task without a goal no word, as before."""
    manifest = Manifest(make_cell(), status="done", **told).write(tmp_path)
    assert read_manifest(tmp_path) == manifest
    assert ("error" in json.loads((tmp_path / MANIFEST).read_text())) is bool(told)


GONE = object()
WRONG = {
    "format": [GONE, "new"],
    "status": [GONE, "fine", None, 1],
    "seconds": ["1", -1, None, []],
    "reason": [3, None, {}],
    "environment": [[], "x", {"versions": []}, {"versions": {"numpy": 2}}, {"machine": 3}, {"machine": {"cores": "2"}}],
    "files": [[], {"../up": "0" * 64}, {"a": "short"}, {"/etc/passwd": "0" * 64}, {"a/../../b": "0" * 64}],
    "cell": [GONE, None, [], {}, {"seed": 1}, "x"],
    "training_seconds": ["1", None],
    "resumed_from": [-1, "x", 1.5],
    "note": [None, 3],
    "surprise": [0],
}


@pytest.mark.parametrize("key", WRONG)
def test_manifest_of_another_form_is_refused(make_cell, tmp_path, key, subtests):
    """Keys that are missing, unknown or of another type: one line names the file; nothing else is raised, ever."""
    Manifest(make_cell(), status="done").write(tmp_path)
    data = {**json.loads((tmp_path / MANIFEST).read_text()), "format": 1}
    del data["digest"]
    for value in WRONG[key]:
        changed = {name: it for name, it in {**data, key: value}.items() if it is not GONE}
        (tmp_path / MANIFEST).write_text(json.dumps(changed))
        told = f"{re.escape(str(tmp_path / MANIFEST))} is no readable manifest: ValueError: "
        with subtests.test(value=value), pytest.raises(SchemaError, match=told):
            read_manifest(tmp_path)


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b"3", b'"done"', b"null", b"\xff\xfe", None])
def test_file_that_is_no_manifest_is_refused(tmp_path, content):
    """Whatever is in the file, and where there is none, the error is ours."""
    if content is not None:
        (tmp_path / MANIFEST).write_bytes(content)
    with pytest.raises(SchemaError, match="no readable manifest"):
        read_manifest(tmp_path)


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
    "a part more": ("trace-00001.parquet", lambda path: path.write_bytes(b"rows"), "was added to what was recorded"),
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
