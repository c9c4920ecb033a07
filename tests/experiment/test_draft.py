"""A folder that comes to be there all at once."""

import os
import re

import pytest

from harness.experiment.run_cell import draft_of
from harness.record import LOG, MANIFEST, Manifest, partial_folder, read_manifest


def test_folder_is_there_when_the_work_is_done(make_cell, tmp_path):
    """Not before; then with its files, and a record of start and duration."""
    with draft_of(tmp_path / "cell", Manifest(make_cell(), status="done")) as draft:
        (draft.partial / "file").touch()
        assert not (tmp_path / "cell").exists()
    assert {path.name for path in (tmp_path / "cell").iterdir()} == {"file", MANIFEST}
    manifest = read_manifest(tmp_path / "cell")
    assert (manifest.status, manifest.reason) == ("done", "")
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\+00:00", manifest.started)
    assert manifest.seconds >= 0.0


@pytest.mark.parametrize("error", [RuntimeError("the arm\nfell off"), SystemExit(3)], ids=repr)
def test_failure_costs_the_folder_alone(make_cell, tmp_path, error):
    """The reason is in the record with what was noted before, the traceback in the log."""
    with draft_of(tmp_path / "cell", Manifest(make_cell(), status="done")) as draft:
        draft.note(resumed_from=7)
        raise error
    manifest = read_manifest(tmp_path / "cell")
    assert (manifest.status, manifest.resumed_from) == ("failed", 7)
    assert manifest.reason == f"{type(error).__name__}: {' '.join(str(error).split())}"
    assert "Traceback" in (tmp_path / "cell" / LOG).read_text()


def test_interrupt_leaves_no_folder(make_cell, tmp_path):
    """Who stops the work has not failed: only the partial folder stays."""
    with pytest.raises(KeyboardInterrupt), draft_of(tmp_path / "cell", Manifest(make_cell(), status="done")):
        raise KeyboardInterrupt
    assert not (tmp_path / "cell").exists()
    assert partial_folder(tmp_path / "cell").exists()


def test_a_failure_is_not_told_in_a_file_of_somebody_else(make_cell, tmp_path):
    """A log that was left as a second name of a file is replaced before it is appended to."""
    elsewhere, partial = tmp_path / "diary.txt", partial_folder(tmp_path / "cell")
    elsewhere.write_text("mine")
    partial.mkdir()
    os.link(elsewhere, partial / LOG)
    with draft_of(tmp_path / "cell", Manifest(make_cell(), status="done")):
        raise RuntimeError("the arm fell off")
    assert elsewhere.read_text() == "mine"
    assert "the arm fell off" in (tmp_path / "cell" / LOG).read_text()
