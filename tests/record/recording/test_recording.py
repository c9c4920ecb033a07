"""The folder of a recorded training: what is written is read, and what is damaged is named."""

import re
import shutil
from dataclasses import replace

import numpy as np
import pytest

from harness.errors import NewerFormat, SchemaError, UsageError
from harness.files.bounded import seal, unseal
from harness.log import in_memory
from harness.record import TrainingFacts, read_recording
from harness.record.recording.facts import Failure, Source
from harness.record.recording.recording_writer import RecordingWriter, write_recording
from tests.record.recording.told import change_first

FACTS = TrainingFacts(
    rewards=("v1", "v2"),
    trained_with="v2",
    behaviour=("success",),
    num_envs=2,
    seed=7,
    env="Some-v0",
    spec={"id": "Some-v0", "kwargs": {"gravity": 9.81}},
    versions={"gymnasium": "1.2"},
    sources={"reward/v1": Source("a" * 64, "def v1(): ..."), "reward/v2": Source("", "what the env pays")},
    failed=(Failure("reward/v1", env=1, episode=3, step=0, reason="ValueError: no"),),
)


def _training(calls, facts=FACTS):
    """Two envs, episodes of five steps."""
    time = np.repeat(np.arange(calls), 2)
    numbers = np.random.default_rng(0).normal(size=(3, len(time)))
    columns = {
        "tick": time,
        "env": np.tile(np.arange(2, dtype=np.int32), calls),
        "episode": (time // 5).astype(np.int32),
        "step": (time % 5).astype(np.int32),
        "reward/v1": numbers[0],
        "reward/v2": numbers[1],
        "behaviour/success": numbers[2],
        "terminated": time % 5 == 4,
        "truncated": np.zeros(len(time), bool),
    }
    return in_memory(facts, columns)


def _require_same(found, expected):
    assert found.names == ("time", *expected.names)
    assert found["time"].tolist() == [*range(1, len(expected) + 1)]
    for name in expected.names if len(expected) else ():
        assert found[name].dtype == expected[name].dtype
        assert np.array_equal(found[name], expected[name], equal_nan=True), name


@pytest.mark.parametrize("calls", [0, 3, 7, 20])
@pytest.mark.usefixtures("small_parts")
def test_what_is_written_is_read(tmp_path, calls):
    """To the last bit, whether parts are full or not; and the facts."""
    write_recording(tmp_path / "run", _training(calls))
    found = read_recording(tmp_path / "run")
    _require_same(found, _training(calls))
    assert found.facts == replace(FACTS, path=tmp_path / "run", closed=True)
    assert len(found) == 2 * calls
    assert len(list((tmp_path / "run").glob("steps-0-*.parquet"))) == -(-2 * calls // 7)


@pytest.fixture
def folder(tmp_path, small_parts):
    """A recording of 20 steps in three parts."""
    write_recording(tmp_path / "run", _training(10))
    return tmp_path / "run"


def test_recording_is_told_from_other_folders(folder):
    """By its file of facts."""
    with pytest.raises(SchemaError, match=r"is no recording of a training: it has no recording-0\.json"):
        read_recording(folder.parent)


def test_envs_of_several_recorders_are_numbered_on(folder):
    """Rows stand in the order of time, and so do the failures' envs."""
    expected = _training(10)
    writer = RecordingWriter(folder, replace(FACTS, num_envs=1, seed=8, paid_otherwise="here"), number=3)
    writer.append([[4, 0, 0, 0, 10.0, 20.0, 30.0, True, False]])
    assert len(read_recording(folder)) == len(expected)  # the writer has not written its step yet
    writer.close()
    found = read_recording(folder)
    assert found["env"][8:11].tolist() == [0, 1, 2]
    assert found["tick"][8:11].tolist() == [4, 4, 4]
    assert found["reward/v2"][10] == 20.0
    assert (len(found), found.facts.num_envs, found.facts.seed) == (len(expected) + 1, 3, 7)
    assert [failure.env for failure in found.facts.failures] == [1, 3]
    assert found.facts.paid_otherwise == "here"


def test_recording_is_closed_when_all_its_recorders_are(folder):
    """One that still records, or was killed, leaves it open."""
    writer = RecordingWriter(folder, replace(FACTS, num_envs=1), number=1)
    assert not read_recording(folder).facts.closed
    writer.close()
    assert read_recording(folder).facts.closed


def test_recorders_of_other_rewards_are_not_one_training(folder):
    """The message names both files."""
    RecordingWriter(folder, replace(FACTS, trained_with="v1"), number=1).close()
    with pytest.raises(SchemaError, match=r"recording-1\.json and recording-0\.json tell of different rewards"):
        read_recording(folder)


@pytest.mark.usefixtures("small_parts")
@pytest.mark.parametrize("calls", [2, 7, 9])
def test_recording_goes_on_as_if_it_had_not_stopped(tmp_path, calls):
    """Behind a part that is full or not."""
    whole = _training(12)
    rows = np.stack([whole[name] for name in whole.names], axis=1)
    for part in (rows[: 2 * calls], rows[2 * calls :]):
        writer = RecordingWriter(tmp_path, FACTS, resume=True)
        writer.append(part)
        writer.close()
    _require_same(read_recording(tmp_path), whole)


@pytest.mark.usefixtures("small_parts")
def test_episodes_go_on_where_each_env_was(tmp_path):
    """Even of an env whose last step stands in an earlier part."""
    facts = replace(FACTS, num_envs=3)
    writer = RecordingWriter(tmp_path, facts)
    writer.append([[0, 1, 5, 0, 0, 0, 0, False, False]] + [[t, 0, t, 0, 0, 0, 0, False, False] for t in range(1, 20)])
    writer.close()
    again = RecordingWriter(tmp_path, facts, resume=True)
    assert (again.next_time, again.next_episodes.tolist()) == (20, [20, 6, 0])
    again.close()


def test_fork_does_not_close_the_recording(tmp_path, monkeypatch):
    """A process that inherited the writer writes nothing."""
    writer = RecordingWriter(tmp_path, FACTS)
    with monkeypatch.context() as patch:
        patch.setattr("os.getpid", lambda: -1)
        writer.close()
    assert not read_recording(tmp_path).facts.closed
    writer.close()
    assert read_recording(tmp_path).facts.closed


def _change_facts(folder, **change):
    path = folder / "recording-0.json"
    path.write_bytes(seal({**unseal(path.read_bytes()), **change}))


def _flip(path):
    content = bytearray(path.read_bytes())
    content[len(content) // 3] ^= 0xFF
    path.write_bytes(content)


PART = "steps-0-00001.parquet"
DAMAGES = {
    "facts flipped": (lambda folder: _flip(folder / "recording-0.json"), "recording-0.json"),
    "facts of another form": (lambda folder: _change_facts(folder, num_envs="two"), "num_envs: Input should be"),
    "trained with none of them": (lambda folder: _change_facts(folder, trained_with="v3"), "'v3', which is none of"),
    "a name twice": (lambda folder: _change_facts(folder, rewards=["v2", "v2"]), "a name stands twice"),
    "other columns": (lambda folder: _change_facts(folder, behaviour=["x"]), "has other columns than recording-0.json"),
    "part flipped": (lambda folder: _flip(folder / PART), PART),
    "part missing": (lambda folder: (folder / PART).unlink(), PART),
    "part short": (
        lambda folder: shutil.copy(folder / "steps-0-00002.parquet", folder / PART),
        f"{PART} has 6 steps, not 7",
    ),
    "time back": (lambda folder: change_first(folder / PART, "time", 0), "do not stand in the order of time"),
    "env beyond": (lambda folder: change_first(folder / PART, "env", 2), "steps of an env beyond its 2"),
    "step below 0": (lambda folder: change_first(folder / PART, "step", -1), "a step or an episode below 0"),
    "infinite": (lambda folder: change_first(folder / PART, "reward_v1", np.inf), "reward/v1 is infinite"),
}


@pytest.mark.parametrize(("damage", "message"), DAMAGES.values(), ids=DAMAGES)
def test_damage_is_named(folder, damage, message):
    """One line that names the file, or what is wrong with the whole."""
    damage(folder)
    with pytest.raises(SchemaError, match=re.escape(message)):
        read_recording(folder).rows()


def test_newer_recording_is_named(folder):
    """It is not called damaged."""
    _change_facts(folder, format=3)
    with pytest.raises(NewerFormat, match="has format 3, this version reads up to 2"):
        read_recording(folder)


@pytest.mark.parametrize(
    ("name", "most", "told"),
    [
        ("MOST_PARTS", 2, "3 parts, 2 are"),
        ("PART_ROWS", 2, "7 steps, not 2"),
        ("MOST_RECORDERS", 0, "1 rec"),
        ("MOST_NUMBERS", 10, r"7 rows of \d+ numbers, 3 are allowed"),
    ],
)
def test_bounds_are_held_before_steps_are_read(folder, monkeypatch, name, most, told):
    """Of parts, rows, recorders; ten million steps of 16,000 columns are a terabyte, though each part is small."""
    monkeypatch.setattr(f"harness.record.recording.recorded_training.{name}", most)
    with pytest.raises(SchemaError, match=told):
        read_recording(folder).rows()


def test_whole_recording_is_not_written_over(folder):
    """What is there stays."""
    with pytest.raises(UsageError, match="holds a recording already"):
        write_recording(folder, _training(1))
    assert len(read_recording(folder)) == 20


def test_million_steps_take_30_megabytes(tmp_path):
    """At most, with two rewards and two measures whose digits nothing repeats; told by a tenth of them."""
    time = np.arange(100_000)
    numbers = np.random.default_rng(0).normal(size=(3, len(time)))
    columns = {
        "tick": time,
        "env": np.zeros(len(time), np.int32),
        "episode": time // 200,
        "step": time % 200,
        **dict(zip(("reward/v1", "reward/v2", "behaviour/distance"), numbers, strict=True)),
        "behaviour/success": time % 200 > 150,
        "terminated": time % 200 == 199,
        "truncated": np.zeros(len(time), bool),
    }
    facts = TrainingFacts(rewards=("v1", "v2"), trained_with="v1", behaviour=("distance", "success"))
    write_recording(tmp_path, in_memory(facts, columns))
    assert sum(path.stat().st_size for path in tmp_path.iterdir()) <= 3_000_000


def test_only_steps_wait_for_the_disk(tmp_path, monkeypatch):
    """A training begins at once; what it has recorded at its end also survives a machine that stops."""
    waited = []
    monkeypatch.setattr("harness.files.bounded.sync", waited.append)
    training = _training(3)
    writer = RecordingWriter(tmp_path / "it", FACTS)
    assert not waited
    writer.append(np.zeros((len(training), 9)))
    writer.close()
    assert len(waited) == 3  # facts, steps, and the folder that holds both


@pytest.mark.parametrize(
    ("column", "row", "value"),
    [("step", 5, 7), ("step", 0, 1), ("episode", 5, 9), ("tick", 4, 1)],
)
def test_steps_that_do_not_follow_one_another_are_refused(tmp_path, column, row, value):
    """A row that is missing, doubled or of another episode would pay episodes otherwise."""
    training = _training(20)
    training[column][row] = value
    write_recording(tmp_path / "run", training)
    with pytest.raises(SchemaError, match=r"does not follow|order of time"):
        read_recording(tmp_path / "run").rows(["env"])


def test_a_reward_without_a_value_is_refused_unless_a_failure_is_told(tmp_path):
    """Otherwise every mean of it would be none."""
    training = _training(20)
    for name in ("v1", "v2"):
        training[f"reward/{name}"][30] = np.nan
    write_recording(tmp_path / "run", training)
    with pytest.raises(SchemaError, match="reward/v2 has no value in some steps"):
        read_recording(tmp_path / "run").rows()
