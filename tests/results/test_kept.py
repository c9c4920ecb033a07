"""What is kept beside a cell's files: believed while it follows from the same, made again otherwise."""

import json

import numpy as np
import pytest

import harness.results.kept as module
from harness.results.kept import Kept

REWARDS = np.array([0.0, -0.1, 0.3])


class Maker:
    """Makes something, and counts how often."""

    def __init__(self, made: object) -> None:
        self.made, self.calls = made, 0

    def __call__(self):
        """Once more."""
        self.calls += 1
        return self.made


@pytest.fixture(name="open_kept")
def _open_kept(tmp_path):
    """Opens what is kept of one cell, as a new process does."""
    (tmp_path / "cell").mkdir()
    (tmp_path / "cell" / "file").write_text("content")
    return lambda: Kept(tmp_path, "cell", tmp_path / "cell", {})


@pytest.fixture(name="folder")
def _folder(tmp_path):
    return tmp_path / "derived" / "cell"


def made_again(open_kept, made_of="x"):
    """How often a number and rewards are made again."""
    number, rewards = Maker(0.5), Maker(REWARDS)
    kept = open_kept()
    assert kept.told("number", [made_of], number) == 0.5
    np.testing.assert_array_equal(kept.told("rewards", [made_of], rewards), REWARDS)
    kept.save()
    return [number.calls, rewards.calls]


def test_rewards_of_before_are_removed(open_kept, folder):
    """A folder does not fill with what nobody asks for any more."""
    made_again(open_kept, "x")
    made_again(open_kept, "y")
    assert len(list(folder.glob("*.array"))) == 1


def test_other_code_makes_all_again(open_kept, monkeypatch):
    """What turns files into results may be another in the next version."""
    made_again(open_kept)
    monkeypatch.setattr(module, "_code", lambda: "another")
    assert made_again(open_kept) == [1, 1]


def test_damaged_files_are_made_again(open_kept, folder):
    """Nothing of them is believed."""
    made_again(open_kept)
    for path in folder.iterdir():
        content = bytearray(path.read_bytes())
        content[-2] ^= 1
        path.write_bytes(content)
    assert made_again(open_kept) == [1, 1]
    assert made_again(open_kept) == [0, 0]


def test_files_of_another_cell_are_not_believed(open_kept, folder, tmp_path):
    """Whole as they are."""
    made_again(open_kept)
    folder.rename(folder.with_name("other"))
    assert made_again(lambda: Kept(tmp_path, "other", tmp_path / "other", {})) == [1, 1]


@pytest.mark.parametrize("number", [None, 3, 0.1, True, float("inf"), np.float64(0.3)])
def test_number_comes_back_as_it_was(open_kept, number):
    """With its type, which decides how it is printed."""
    kept = open_kept()
    made = kept.told("it", [], lambda: number)
    kept.save()
    found = open_kept().told("it", [], Maker(None))
    assert json.dumps(found) == json.dumps(made) == json.dumps(number)


def test_error_passes(open_kept):
    """Nothing is kept of it."""

    def fail():
        raise ValueError("no")

    with pytest.raises(ValueError, match="no"):
        open_kept().told("it", [], fail)
    assert made_again(open_kept) == [1, 1]


def test_digest_is_the_manifest_s(open_kept, tmp_path):
    """Who opens a cell has compared it with the file."""
    assert Kept(tmp_path, "cell", tmp_path / "cell", {"file": "abc"}).digest("file") == "abc"


def test_digest_of_a_cell_without_any_is_taken(open_kept, tmp_path):
    """Version 0.1 wrote none down."""
    before = open_kept().digest("file")
    (tmp_path / "cell" / "file").write_text("CONTENT")
    assert open_kept().digest("file") != before


def test_missing_file_has_no_digest(open_kept):
    """Whoever reads it says that it is missing."""
    assert open_kept().digest("none") == ""


def test_numbers_are_saved_once(open_kept, folder):
    """Where none is new, nothing is written."""
    made_again(open_kept)
    before = (folder / "values").stat().st_mtime_ns
    made_again(open_kept)
    assert (folder / "values").stat().st_mtime_ns == before
