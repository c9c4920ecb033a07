"""Digests of files that were made from others."""

import shutil
import subprocess

import pytest

from harness.files.bounded import (
    FIRST_LINE,
    SUMS,
    changed_since_made,
    forget_made,
    making,
    note_made,
    read_sums,
)


@pytest.fixture
def folder(tmp_path):
    """Two files that were made."""
    for name in ("report.html", "results.parquet"):
        (tmp_path / name).write_text(name)
        note_made(tmp_path / name)
    return tmp_path


def test_nothing_has_changed(folder):
    """A folder as it was made; one without made files too."""
    assert changed_since_made(folder) == []
    assert changed_since_made(folder.parent) == []


def test_made_again_it_has_another_digest(folder):
    """In place of the earlier one."""
    (folder / "report.html").write_text("newer")
    assert changed_since_made(folder) == ["report.html"]
    note_made(folder / "report.html")
    assert changed_since_made(folder) == []


def test_missing_file_has_changed(folder):
    """Until another file is made: then it is forgotten."""
    (folder / "report.html").unlink()
    assert changed_since_made(folder) == ["report.html"]
    note_made(folder / "results.parquet")
    assert read_sums(folder).keys() == {"results.parquet"}


def test_every_flipped_bit_of_the_sums_is_found(folder):
    """It names the file that it told of, or itself."""
    text = (folder / SUMS).read_bytes()
    for place in range(0, len(text) * 8, 7):
        flipped = bytearray(text)
        flipped[place // 8] ^= 1 << place % 8
        (folder / SUMS).write_bytes(flipped)
        assert changed_since_made(folder)


@pytest.mark.skipif(shutil.which("sha256sum") is None, reason="there is no sha256sum")
def test_sha256sum_reads_it(folder):
    """Who has no harness checks it all the same."""
    ended = subprocess.run(["sha256sum", "--check", SUMS], cwd=folder, capture_output=True, text=True, check=True)
    assert ended.stdout == "report.html: OK\nresults.parquet: OK\n"


def test_made_in_place_of_an_earlier_one(folder):
    """Its digest is noted, the others stay."""
    with making(folder / "report.html"):
        (folder / "report.html").write_text("newer")
    assert changed_since_made(folder) == []
    assert read_sums(folder).keys() == {"report.html", "results.parquet"}


def test_killed_while_a_file_is_made_there_is_no_digest_of_it(folder):
    """Neither the earlier file nor the newer one is said to be damaged."""
    with making(folder / "report.html"):
        assert changed_since_made(folder) == []
        (folder / "report.html").write_text("newer")
        assert changed_since_made(folder) == []
        assert read_sums(folder).keys() == {"results.parquet"}


def test_a_list_that_somebody_else_made_stays_as_it_is(tmp_path):
    """Neither believed nor written."""
    (tmp_path / SUMS).write_text(f"{'0' * 64}  notes.txt\n")
    (tmp_path / "report.html").write_text("made")
    with making(tmp_path / "report.html"):
        pass
    forget_made(tmp_path / "report.html")
    assert (tmp_path / SUMS).read_text() == f"{'0' * 64}  notes.txt\n"
    assert (read_sums(tmp_path), changed_since_made(tmp_path)) == ({}, [])


def test_lists_of_the_first_version_are_ours(folder):
    """They had no first line that says so."""
    (folder / SUMS).write_text((folder / SUMS).read_text().removeprefix(f"{FIRST_LINE}\n"))
    assert (len(read_sums(folder)), changed_since_made(folder)) == (2, [])
