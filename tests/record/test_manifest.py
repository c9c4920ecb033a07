"""What a cell says of itself."""

import json
import re

import pytest

from harness.errors import NewerFormat, SchemaError
from harness.record import MANIFEST, Manifest, read_manifest


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


def test_newer_format_is_refused(tmp_path):
    """A file of a later version is not guessed at: the message says both versions."""
    newer = Manifest.FORMAT + 1
    (tmp_path / MANIFEST).write_text(json.dumps({"format": newer}))
    with pytest.raises(NewerFormat, match=f"{MANIFEST} has format {newer}, this version reads up to {newer - 1}"):
        read_manifest(tmp_path)


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
    "id": [3, "other"],
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
