"""What a cell says of itself."""

import json
import re
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest

from harness.errors import SchemaError
from harness.experiment.provenance import describe_environment, describe_machine, installed_versions, source_hashes
from harness.record.cell import Cell
from harness.record.folder import MANIFEST
from harness.record.manifest import FORMAT, Manifest, now, read_manifest
from harness.registry.choice import Choice
from harness.registry.registry import Registry, load_registry
from harness_plugins.rewards import arp

MakeCell = Callable[..., Cell]


def _write(folder: Path, cell: Cell, changes: dict[str, object]) -> Path:
    """A manifest's folder, some keys of the file changed; None takes a key away."""
    Manifest(cell, "done").write(folder)
    data = {**json.loads((folder / MANIFEST).read_text()), **changes}
    (folder / MANIFEST).write_text(json.dumps({key: value for key, value in data.items() if value is not None}))
    return folder


def test_manifest_is_read_as_it_was_written(make_cell: MakeCell, tmp_path: Path):
    """Every field comes back."""
    manifest = Manifest(make_cell(), "failed", "no luck", now(), 1.5, 0.25, {"versions": {"numpy": "2"}})
    manifest.write(tmp_path)
    assert read_manifest(tmp_path) == manifest


def test_manifest_names_its_format_and_cell(make_cell: MakeCell, tmp_path: Path):
    """Another program finds the version of the file and the cell's id in it."""
    Manifest(make_cell(), "done").write(tmp_path)
    data = json.loads((tmp_path / MANIFEST).read_text())
    assert (data["format"], data["id"]) == (FORMAT, make_cell().id)


def test_newer_format_is_refused(make_cell: MakeCell, tmp_path: Path):
    """A file of a later version is not guessed at: the message says both versions."""
    folder = _write(tmp_path, make_cell(), {"format": FORMAT + 1})
    with pytest.raises(SchemaError, match=rf"{MANIFEST} has format {FORMAT + 1}, this version reads up to {FORMAT}"):
        read_manifest(folder)


@pytest.mark.parametrize(
    "change",
    [
        {"format": None},
        {"format": "new"},
        {"cell": None},
        {"cell": []},
        {"cell": {"seed": 1}},
        {"status": None},
        {"surprise": 0},
    ],
    ids=str,
)
def test_damaged_manifest_is_refused(make_cell: MakeCell, tmp_path: Path, change: dict[str, object]):
    """Keys that are missing, unknown or of another type make the file unreadable, and the message names it."""
    folder = _write(tmp_path, make_cell(), change)
    with pytest.raises(SchemaError, match=f"{re.escape(str(folder / MANIFEST))} is no readable manifest"):
        read_manifest(folder)


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b"3", b'"done"', b"null", b"\xff\xfe"], ids=repr)
def test_file_that_is_no_manifest_is_refused(tmp_path: Path, content: bytes):
    """Whatever is in the file, the error is ours."""
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


def test_environment_of_a_run(make_cell: MakeCell, toys: Registry, monkeypatch: pytest.MonkeyPatch):
    """What decides a result beside the cell, as JSON: versions, machine, commit, command, sources."""
    monkeypatch.setattr("sys.argv", ["/somewhere/bin/harness", "run", "--sim", "ideal"])
    described = describe_environment(make_cell(), toys)
    assert list(described) == ["versions", "machine", "commit", "command", "sources"]
    assert described["command"] == "harness run --sim ideal"
    assert json.loads(json.dumps(described)) == described


def test_versions_are_those_that_run():
    """The numpy of this process is the one that is recorded."""
    assert installed_versions()["numpy"] == np.__version__


def test_machine_names_its_cpu():
    """The CPU decides which floating-point kernels run."""
    machine = describe_machine()
    assert machine["cpu"]
    assert machine["cores"] >= 1


def test_sources_are_hashes_of_the_files(make_cell: MakeCell, toys: Registry):
    """A result whose reward was changed since can be told by the hash of the reward's file."""
    hashes = source_hashes(make_cell(reward=Choice("arp", (), "arp")), toys)
    assert set(hashes) == {"simulators", "tasks", "algorithms", "rewards", "robots"}
    assert hashes["rewards"] == sha256(Path(arp.__file__).read_bytes()).hexdigest()


def test_environment_without_a_cell_has_no_sources():
    """`harness doctor` describes the machine alone."""
    assert describe_environment(None, load_registry())["sources"] == {}
