"""One process that trains a cell: from the start, or from where another was killed."""

import time

import numpy as np
import pytest

from harness.errors import SchemaError
from harness.experiment.checkpoints.checkpoint import Checkpoint, begin_attempt
from harness.record import LOG

ENVIRONMENT = {
    "versions": {"numpy": "2"}, "machine": {"kernel": "Haswell"}, "commit": "", "sources": {"rewards": "abc"},
    "command": "harness run",
}  # fmt: skip


def _origin(cell):
    told = {key: ENVIRONMENT[key] for key in ("versions", "commit", "sources")}
    return {"cell": cell.id, **told, "kernel": "Haswell"}


def _leave_checkpoint(folder, cell, seconds=0.0):
    Checkpoint(7, _origin(cell), {"weight": np.arange(2.0)}, {}, seconds=seconds).write(folder)


def _begin(cell, folder, restore=lambda state: None):
    return begin_attempt(cell, folder, ENVIRONMENT, every=100, restore=restore)


def test_first_attempt_begins_at_the_start(make_cell, tmp_path):
    """With nothing to say, and with the log that the worker has opened already."""
    (tmp_path / LOG).write_text("warming up\n")
    attempt = _begin(make_cell(), tmp_path)
    assert (attempt.begun_from, attempt.rows, attempt.note, attempt.every) == (0, 0, "", 100)
    assert (tmp_path / LOG).read_text() == "warming up\n"


def test_next_attempt_goes_on_from_the_checkpoint(make_cell, tmp_path):
    """The note and the log say from where; the killed process's seconds count up to its checkpoint."""
    _leave_checkpoint(tmp_path, make_cell(), seconds=1000.0)
    attempt = _begin(make_cell(), tmp_path)
    assert (attempt.begun_from, attempt.note) == (7, "went on after 7 steps")
    assert "this one went on after 7 steps" in (tmp_path / LOG).read_text()
    assert (tmp_path / "checkpoint.safetensors").exists()
    time.sleep(0.01)
    assert 1000.01 <= attempt.seconds < 1100.0


@pytest.mark.parametrize("before", ["SkylakeX", "SkylakeX and then Haswell"])
def test_checkpoint_of_another_kernel_is_gone_on_from_and_told(make_cell, tmp_path, before):
    """The note and the log name both, as long as the training lasts: neither kernel gives such bytes."""
    Checkpoint(7, {**_origin(make_cell()), "kernel": before}, {}, {}).write(tmp_path)
    attempt = _begin(make_cell(), tmp_path)
    assert (attempt.begun_from, attempt.origin["kernel"]) == (7, "SkylakeX and then Haswell")
    assert attempt.note.startswith("went on after 7 steps, on the kernel of OpenBLAS SkylakeX and then Haswell: ")
    assert attempt.note in (tmp_path / LOG).read_text()


def test_checkpoint_that_the_simulator_does_not_come_back_to_is_of_no_use(make_cell, tmp_path):
    """Where it moves otherwise than it did, the rest of the training would not be that of the beginning."""
    _leave_checkpoint(tmp_path, make_cell())

    def refuse(state):
        raise SchemaError("the simulator does not repeat itself")

    attempt = _begin(make_cell(), tmp_path, refuse)
    assert attempt.begun_from == 0
    assert attempt.note.endswith("is of no use: the simulator does not repeat itself")
    assert [path.name for path in tmp_path.iterdir()] == [LOG]


def test_checkpoint_of_another_cell_is_of_no_use(make_cell, tmp_path):
    """The training starts over, says why, and nothing but the log is left in the folder."""
    _leave_checkpoint(tmp_path, make_cell(seed=1))
    (tmp_path / "trace.0").touch()
    (tmp_path / "policy").mkdir()
    attempt = _begin(make_cell(), tmp_path)
    assert attempt.begun_from == 0
    assert attempt.note.startswith("started over: checkpoint.safetensors is of no use: ")
    assert [path.name for path in tmp_path.iterdir()] == [LOG]


def test_what_was_left_without_a_checkpoint_is_removed(make_cell, tmp_path):
    """A process that was killed before its first checkpoint, or that writes none."""
    (tmp_path / "trace.0").touch()
    assert _begin(make_cell(), tmp_path).note == "started over: no checkpoint was left"
    assert [path.name for path in tmp_path.iterdir()] == [LOG]
