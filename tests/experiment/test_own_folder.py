"""The folder that work grows in."""

import os

from harness.experiment.run_cell import own_partial


def test_a_log_with_a_second_name_is_copied(tmp_path):
    """What is appended does not reach the file that somebody linked there; what the log said stays."""
    elsewhere = tmp_path / "diary.txt"
    elsewhere.write_text("mine\n")
    partial = own_partial(tmp_path / "cell")
    os.link(elsewhere, partial / "log.txt")
    with (own_partial(tmp_path / "cell") / "log.txt").open("a") as log:
        log.write("more\n")
    assert elsewhere.read_text() == "mine\n"
    assert (partial / "log.txt").read_text() == "mine\nmore\n"


def test_other_files_stay_the_same_ones(tmp_path):
    """A large checkpoint is not copied for nothing."""
    partial = own_partial(tmp_path / "cell")
    (partial / "checkpoint.safetensors").write_bytes(b"1")
    before = (partial / "checkpoint.safetensors").stat().st_ino
    assert (own_partial(tmp_path / "cell") / "checkpoint.safetensors").stat().st_ino == before
