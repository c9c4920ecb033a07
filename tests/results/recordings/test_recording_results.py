"""What follows from a recording's files: read once, and kept."""

import shutil
from collections import Counter
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from harness.errors import SchemaError
from harness.record import read_recording
from harness.report import Report, report_text
from harness.results.recordings.recording_results import RecordingResults
from tests.results.recordings.conftest import load_study


@pytest.fixture
def opened(monkeypatch):
    """How often each Parquet file is opened."""
    counts = Counter()
    real = pq.ParquetFile

    def open_file(path, **options):
        counts[str(path)] += 1
        return real(path, **options)

    monkeypatch.setattr(pq, "ParquetFile", open_file)
    return counts


def _told(folder):
    return report_text(Report(load_study(folder)))


def test_first_report_opens_each_file_once(study_folder, opened):
    """For its episodes, and for what each reward paid."""
    _told(study_folder)
    files = [str(path) for path in study_folder.rglob("steps-*.parquet")]
    assert opened == dict.fromkeys(files, 1)


def test_second_report_opens_no_file_and_says_the_same(study_folder, opened):
    """All of it is kept."""
    first = _told(study_folder)
    opened.clear()
    assert _told(study_folder) == first
    assert not opened


def test_report_says_the_same_without_what_is_kept(study_folder):
    """The folder may be removed at any time."""
    first = _told(study_folder)
    shutil.rmtree(study_folder / "derived")
    assert _told(study_folder) == first


def test_only_the_recording_that_changed_is_read_again(study_folder, opened):
    """The digests of its files are not the same."""
    _told(study_folder)
    opened.clear()
    facts = study_folder / "plain-0" / "recording-0.json"
    shutil.copyfile(study_folder / "plain-1" / "recording-0.json", facts)
    with pytest.raises(Exception, match="plain-0"):  # two trainings of one seed now
        _told(study_folder)
    assert {Path(path).parent.name for path in opened} == {"plain-0"}


def test_damaged_file_is_found_although_everything_is_kept(study_folder):
    """It is one line of the report."""
    _told(study_folder)
    (part,) = (study_folder / "plain-0").glob("steps-*.parquet")
    content = bytearray(part.read_bytes())
    content[len(content) // 2] ^= 1
    part.write_bytes(content)
    assert "plain-0" in "".join(load_study(study_folder).damaged_recordings)


def test_folder_that_allows_no_writing_is_read_all_the_same(study_folder, opened):
    """Of a reward that is asked for later, its column alone is read."""
    (study_folder / "derived").write_text("a file in the place of the folder")
    results = RecordingResults(study_folder, study_folder / "plain-0")
    results.keep()
    opened.clear()
    whole = read_recording(study_folder / "plain-0")
    np.testing.assert_array_equal(results.paid_by("thrice"), whole["reward/thrice"])
    assert sum(opened.values()) == 2


def test_columns_that_are_not_asked_for_are_not_read(study_folder, monkeypatch):
    """But for those by which steps are seen to follow one another."""
    asked, real = [], pq.ParquetFile.iter_batches

    def read(file, *given, columns, **others):
        asked.extend(columns)
        return real(file, *given, columns=columns, **others)

    monkeypatch.setattr(pq.ParquetFile, "iter_batches", read)
    assert len(read_recording(study_folder / "plain-0")["reward/thrice"]) == 200
    assert asked == ["time", "env", "episode", "step", "reward_thrice"]


def test_what_is_kept_is_what_was_recorded(study_folder):
    """Facts, episodes and likeness, also after a way through files."""
    fresh = RecordingResults(study_folder, study_folder / "plain-0")
    numbers = fresh.episodes.numbers
    fresh.keep()
    kept = RecordingResults(study_folder, study_folder / "plain-0")
    assert kept.facts == fresh.facts == read_recording(study_folder / "plain-0").facts
    assert (kept.steps, kept.likeness) == (fresh.steps, fresh.likeness)
    np.testing.assert_array_equal(kept.episodes.numbers, numbers)


def test_folder_without_a_recording_is_refused(tmp_path):
    """As by the reader."""
    with pytest.raises(SchemaError, match="is no recording of a training"):
        _ = RecordingResults(tmp_path, tmp_path / "nothing").facts
