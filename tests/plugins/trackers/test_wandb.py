"""Weights & Biases, offline."""

import time

import pytest

from harness_plugins.trackers.wandb import WandB

wandb = pytest.importorskip("wandb", reason="needs the extra wandb")


def _records(folder):
    """What the only offline run of a folder holds, once its end is there: another process writes it."""
    until = time.monotonic() + 20.0
    while not any(record.HasField("exit") for record in _written(folder)):
        assert time.monotonic() < until, "the run has no end"
        time.sleep(0.05)
    return _written(folder)


def _written(folder):
    """A header, then records of checksum, length, kind and content."""
    from wandb.proto import wandb_internal_pb2

    [path] = folder.glob("wandb/offline-run-*/*.wandb")
    content, found = path.read_bytes(), []
    assert len(content) < 2**15, "records may be split"
    at = 7
    while at + 7 < len(content):
        size = int.from_bytes(content[at + 4 : at + 6], "little")
        found.append(wandb_internal_pb2.Record.FromString(content[at + 7 : at + 7 + size]))
        at += 7 + size
    return found


def test_an_offline_run_holds_cell_and_numbers(tracked):
    """Its name, group, parameters and curve, and how it ended."""
    wandb.teardown()  # what a test before this one left in the process, its folder among it
    track = WandB(mode="offline", project="arms").begin(tracked)
    track.log(100, {"Training/Success Rate": 0.5})
    track.end("failed", "the arm fell off")
    records = _records(tracked.folder)
    [run] = [record.run for record in records if record.HasField("run")]
    assert (run.project, run.run_id, run.display_name) == ("arms", tracked.id, tracked.title)
    assert run.run_group == tracked.group
    assert {item.key or ".".join(item.nested_key) for item in run.config.update} >= {"reward", "seed", "task.horizon"}
    history = [item for record in records if record.HasField("history") for item in record.history.item]
    told = {item.key or ".".join(item.nested_key): item.value_json for item in history}
    assert (told["steps"], told["Training/Success Rate"]) == ("100", "0.5")
    assert [record.exit.exit_code for record in records if record.HasField("exit")] == [1]


def test_who_is_not_logged_in_is_told_how(monkeypatch):
    """Before anything starts; offline nobody has to be."""
    monkeypatch.setattr(wandb, "login", lambda **options: False)
    assert "wandb login" in WandB().why_not()
    assert WandB(mode="offline").why_not() == ""
