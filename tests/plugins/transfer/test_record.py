"""What an evaluation away from home leaves."""

import json

import pytest

from harness.errors import SchemaError
from harness.record import MANIFEST, POLICY
from harness.record.folder import WEIGHTS
from harness.registry import Choice
from harness_plugins.transfer import TransferRecord, read_transfer, simulator_id
from harness_plugins.transfer.record import policy_digest

MUJOCO = Choice("mujoco", (("substeps", 20), ("layers", (1, 2))), "mujoco")


def _record(**fields):
    return TransferRecord("0123", MUJOCO, "abc", **{"status": "done", **fields})


def _change(folder, change):
    data = json.loads((folder / MANIFEST).read_text())
    change(data)
    (folder / MANIFEST).write_text(json.dumps(data))


def test_record_is_read_as_it_was_written(tmp_path):
    """Every field comes back, the simulator's parameters too."""
    told = {"reason": "no luck", "started": "2026-01-01T00:00:00+00:00", "seconds": 1.5}
    record = _record(status="failed", **told, environment={"versions": {"numpy": "2"}})
    record.write(tmp_path)
    assert read_transfer(tmp_path) == record


def test_folder_without_a_record_has_none(tmp_path):
    """Nothing was evaluated there yet."""
    assert read_transfer(tmp_path) is None


def test_newer_format_is_refused(tmp_path):
    """The message says both versions."""
    _record().write(tmp_path)
    _change(tmp_path, lambda data: data.update(format=TransferRecord.FORMAT + 1))
    with pytest.raises(SchemaError, match=f"has format {TransferRecord.FORMAT + 1}, this version reads up to"):
        read_transfer(tmp_path)


@pytest.mark.parametrize("key", ["simulator", "policy", "status", "format"])
def test_damaged_record_says_so(tmp_path, key):
    """The reason names the file, and what it should be."""
    _record().write(tmp_path)
    _change(tmp_path, lambda data: data.pop(key))
    record = read_transfer(tmp_path)
    assert record is not None
    assert record.status == "damaged"
    assert "manifest.json is no readable record of a transfer" in record.reason


@pytest.mark.parametrize(("digest", "expected"), [("abc", True), ("def", False), ("", True)])
def test_record_is_of_one_policy(digest, expected):
    """Of the weights that it names; where a cell has no weights any more, there is no other policy to mean."""
    assert _record().is_of(digest) is expected


def test_simulators_have_folders_of_their_own():
    """By name and parameters; the label says nothing more."""
    other = Choice("mujoco", (("substeps", 40), ("layers", (1, 2))), "mujoco")
    assert simulator_id(MUJOCO) == simulator_id(Choice("mujoco", MUJOCO.params, "another label"))
    assert simulator_id(MUJOCO) != simulator_id(other)
    assert simulator_id(MUJOCO).startswith("mujoco-")


def test_digest_is_that_of_the_weights(tmp_path):
    """Other weights have another; a cell without weights has none."""
    assert policy_digest(tmp_path) == ""
    (tmp_path / POLICY).mkdir()
    digests = set()
    for content in (b"1", b"2"):
        (tmp_path / POLICY / WEIGHTS).write_bytes(content)
        digests.add(policy_digest(tmp_path))
    assert len(digests - {""}) == 2
