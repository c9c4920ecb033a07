"""Whether a cell's folder still is what was left there."""

import json
import os
from collections.abc import Callable
from pathlib import Path

import pytest

from harness.errors import NewerFormat, SchemaError
from harness.record.cell import Cell
from harness.record.cell_folder import examine
from harness.record.folder import LOG, MANIFEST, TRACE
from harness.record.manifest import Manifest, read_manifest

MakeCell = Callable[..., Cell]


@pytest.fixture
def folder(make_cell: MakeCell, tmp_path: Path) -> Path:
    """Of a done cell."""
    (tmp_path / "cell").mkdir()
    (tmp_path / "cell" / TRACE).write_bytes(b"rows")
    (tmp_path / "cell" / LOG).write_text("said\n")
    Manifest(make_cell(), status="done").write(tmp_path / "cell")
    return tmp_path / "cell"


def test_sound_cell_is_what_its_manifest_says(make_cell: MakeCell, folder: Path):
    """Its digests included."""
    assert examine(folder, make_cell()) == read_manifest(folder)
    assert read_manifest(folder).files.keys() == {TRACE, LOG}


def test_cell_without_a_folder_is_pending(make_cell: MakeCell, tmp_path: Path):
    """It was never run."""
    assert examine(tmp_path / "none", make_cell()).status == "pending"


def _link(path: Path) -> None:
    path.rename(path.with_name("other"))
    path.symlink_to(path.with_name("other"))


def _pipe(path: Path) -> None:
    path.unlink()
    os.mkfifo(path)


DAMAGES = {
    "changed": (TRACE, lambda path: path.write_bytes(b"Rows"), "is not what was written: its SHA-256 differs"),
    "missing": (TRACE, Path.unlink, "is missing"),
    "a link": (TRACE, _link, "is a link"),
    "a pipe": (TRACE, _pipe, "is missing"),
    "changed log": (LOG, lambda path: path.write_text("Said\n"), "is not what was written"),
    "cut manifest": (MANIFEST, lambda path: path.write_bytes(path.read_bytes()[:50]), "is no readable manifest"),
    "no manifest": (MANIFEST, Path.unlink, "is no readable manifest"),
    "manifest that is a pipe": (MANIFEST, _pipe, "it is no regular file"),
}


@pytest.mark.parametrize(("name", "damage", "message"), DAMAGES.values(), ids=DAMAGES)
def test_damage_is_told(make_cell: MakeCell, folder: Path, name: str, damage: Callable[[Path], object], message: str):
    """Which file, what is wrong, what to do."""
    damage(folder / name)
    found = examine(folder, make_cell())
    assert (found.status, found.cell) == ("damaged", make_cell())
    assert f"{folder / name}" in found.reason
    assert message in found.reason
    assert found.reason.endswith("; run again to replace it")


def test_cell_of_a_newer_version_is_no_damage(make_cell: MakeCell, folder: Path):
    """Nothing may replace it."""
    (folder / MANIFEST).write_text('{"format": 3}')
    with pytest.raises(NewerFormat, match="has format 3"):
        examine(folder, make_cell())


WRONG = {
    "status": ["fine", None, 1],
    "seconds": ["1", -1, None, []],
    "reason": [3, None, {}],
    "environment": [[], "x", {"versions": []}, {"versions": {"numpy": 2}}, {"machine": 3}, {"machine": {"cores": "2"}}],
    "files": [[], {"../up": "0" * 64}, {"a": "short"}, {"/etc/passwd": "0" * 64}, {"a/../../b": "0" * 64}],
    "cell": [None, [], {}, "x"],
    "training_seconds": ["1", None],
    "resumed_from": [-1, "x", 1.5],
    "note": [None, 3],
    "id": [3, "other"],
}


@pytest.mark.parametrize(("key", "value"), [(key, value) for key, values in WRONG.items() for value in values], ids=str)
def test_manifest_with_a_wrong_type_is_refused(make_cell: MakeCell, tmp_path: Path, key: str, value: object):
    """One line names the file; nothing else is raised, now or later."""
    Manifest(make_cell(), status="done").write(tmp_path)
    data = {**json.loads((tmp_path / MANIFEST).read_text()), "format": 1, key: value}
    del data["digest"]
    (tmp_path / MANIFEST).write_text(json.dumps(data))
    with pytest.raises(SchemaError, match=rf"{MANIFEST} is no readable manifest: ValueError: "):
        read_manifest(tmp_path)
