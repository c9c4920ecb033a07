"""What is read of a recording while it is written, and of a trace."""

import pyarrow.parquet as pq
from numpy.testing import assert_array_equal

from harness.record import read_recording
from harness.results.recordings.episodes import episodes_of
from harness_plugins.watch.recorded import Recording


def test_it_says_what_the_whole_recording_says(record, step):
    """Whatever lay between two looks, parts that became full too."""
    env = record()
    recording = Recording(env._recorder._writer.folder)
    for count in (1, 14, 2, 33, 16, 5):
        step(env, count)
        recording.look()
    whole = episodes_of(read_recording(recording.folder))
    assert recording.blocks.episodes.sum() == len(whole.last) == 71 // 3
    assert recording.blocks.steps.tolist() == (whole.last + 1).tolist()
    assert_array_equal(recording.blocks.means[:, 0], whole.returns["counted"])
    assert_array_equal(recording.blocks.means[:, 1], whole.behaviour["success"])


def test_a_full_part_is_read_once(record, step, monkeypatch):
    """However often somebody looks: of 5 parts the last one alone is read again, and nothing if nothing is new."""
    env = record()
    step(env, 70)
    read, real = [], pq.ParquetFile
    monkeypatch.setattr(pq, "ParquetFile", lambda path, **given: read.append(path) or real(path, **given))
    recording = Recording(env._recorder._writer.folder)
    recording.look()
    assert len(read) == 5
    recording.look()
    assert len(read) == 5
    step(env, 1)
    recording.look()
    assert len(read) == 6


def test_several_recorders_are_one_training(record, step):
    """Their episodes in the order of time; steps are counted over all of them."""
    envs = [record(number=number) for number in range(2)]
    for env in envs:
        step(env, 6)
    recording = Recording(envs[0]._recorder._writer.folder)
    recording.look()
    assert recording.steps == 12
    assert recording.blocks.steps.tolist() == [6, 6, 12, 12]
