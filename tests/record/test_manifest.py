"""What a cell says of itself."""

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest

from harness.errors import SchemaError
from harness.record.cell import Cell
from harness.record.folder import MANIFEST
from harness.record.manifest import Manifest, now, read_manifest

MakeCell = Callable[..., Cell]


def _write(folder: Path, cell: Cell, changes: dict[str, object]) -> Path:
    """A manifest's folder, some keys of the file changed; None takes a key away."""
    Manifest(cell, status="done").write(folder)
    data = {**json.loads((folder / MANIFEST).read_text()), **changes}
    (folder / MANIFEST).write_text(json.dumps({key: value for key, value in data.items() if value is not None}))
    return folder


def test_manifest_is_read_as_it_was_written(make_cell: MakeCell, tmp_path: Path):
    """Every field comes back."""
    told = {"status": "failed", "reason": "no luck", "started": now(), "seconds": 1.5}
    manifest = Manifest(make_cell(), 0.25, 6, "went on", **told, environment={"versions": {"numpy": "2"}})
    manifest.write(tmp_path)
    assert read_manifest(tmp_path) == manifest


def test_manifest_tells_the_error_of_a_goal(make_cell: MakeCell, tmp_path: Path):
    """Its name and unit; of a task without a goal no word, as before."""
    for number, told in enumerate(({"error": "pose error", "unit": "m"}, {})):
        folder = tmp_path / str(number)
        folder.mkdir()
        manifest = Manifest(make_cell(), status="done", **told).write(folder)
        assert read_manifest(folder) == manifest
        assert ("error" in json.loads((folder / MANIFEST).read_text())) is bool(told)


def test_manifest_names_its_format_and_cell(make_cell: MakeCell, tmp_path: Path):
    """Another program finds the version of the file and the cell's id in it."""
    Manifest(make_cell(), status="done").write(tmp_path)
    data = json.loads((tmp_path / MANIFEST).read_text())
    assert (data["format"], data["id"]) == (Manifest.FORMAT, make_cell().id)


def test_newer_format_is_refused(make_cell: MakeCell, tmp_path: Path):
    """A file of a later version is not guessed at: the message says both versions."""
    newer = Manifest.FORMAT + 1
    folder = _write(tmp_path, make_cell(), {"format": newer})
    with pytest.raises(
        SchemaError, match=rf"{MANIFEST} has format {Manifest.FORMAT + 1}, this version reads up to {Manifest.FORMAT}"
    ):
        read_manifest(folder)


def test_damaged_manifest_is_refused(
    make_cell: MakeCell, tmp_path_factory: pytest.TempPathFactory, subtests: pytest.Subtests
):
    """Keys that are missing, unknown or of another type make the file unreadable, and the message names it."""
    rows = [
        {"format": None},
        {"format": "new"},
        {"cell": None},
        {"cell": []},
        {"cell": {"seed": 1}},
        {"status": None},
        {"surprise": 0},
    ]
    for change in rows:
        with subtests.test(change=change):
            tmp_path = tmp_path_factory.mktemp("case")
            folder = _write(tmp_path, make_cell(), change)
            with pytest.raises(SchemaError, match=f"{re.escape(str(folder / MANIFEST))} is no readable manifest"):
                read_manifest(folder)


def test_file_that_is_no_manifest_is_refused(tmp_path_factory: pytest.TempPathFactory, subtests: pytest.Subtests):
    """Whatever is in the file, the error is ours."""
    for content in [b"", b"{", b"[]", b"3", b'"done"', b"null", b"\xff\xfe"]:
        with subtests.test(content=content):
            tmp_path = tmp_path_factory.mktemp("case")
            (tmp_path / MANIFEST).write_bytes(content)
            with pytest.raises(SchemaError, match="no readable manifest"):
                read_manifest(tmp_path)


def test_folder_without_a_manifest_is_refused(tmp_path: Path):
    """There is nothing to read."""
    with pytest.raises(SchemaError, match="no readable manifest"):
        read_manifest(tmp_path)


def test_time_is_utc():
    """ISO 8601 to the second, with the offset."""
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\+00:00", now())
