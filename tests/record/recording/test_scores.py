"""The file of what rewards that were written later say of a recording."""

import json

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from harness.errors import NewerFormat, SchemaError
from harness.log import in_memory
from harness.record import TrainingFacts, read_recording
from harness.record.recording.facts import Failure, Source
from harness.record.recording.recording_writer import RecordingWriter
from harness.record.recording.scores import with_scores, write_scores

FACTS = TrainingFacts(
    rewards=("own", "calm"),
    trained_with="own",
    behaviour=("success",),
    sources={"reward/own": Source("", "what the env pays"), "reward/calm": Source("a" * 64, "old")},
    failed=(Failure("reward/calm", "ValueError: no", env=0, episode=1, step=2),),
)
STEPS = 4
SCORES = in_memory(
    TrainingFacts(
        rewards=("new",),
        trained_with="",
        behaviour=("effort",),
        lower_is_better=("effort",),
        sources={"reward/new": Source("b" * 64, "new"), "behaviour/effort": Source("c" * 64, "effort")},
        failed=(Failure("behaviour/effort", "KeyError: 'x'", env=0, episode=0, step=1),),
    ),
    {"reward/new": np.arange(4.0), "behaviour/effort": np.array([1, np.nan, 3, 4])},
)


def _paid(name, paid, source):
    """Scores of one reward."""
    facts = TrainingFacts(rewards=(name,), trained_with="", sources={f"reward/{name}": source})
    return in_memory(facts, {f"reward/{name}": paid})


@pytest.fixture
def folder(tmp_path):
    """A recording of four steps of one env."""
    writer = RecordingWriter(tmp_path / "run", FACTS)
    writer.append([[time, 0, 0, time, 1.0, 2.0, 0.0, time == 3, False] for time in range(STEPS)])
    writer.close()
    return tmp_path / "run"


def test_recording_has_them_among_its_own(folder):
    """Columns to the last bit, code and failures; the files of the recording stay as they are."""
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    write_scores(folder / "scores-0.parquet", SCORES)
    found = read_recording(folder)
    assert (found.facts.rewards, found.facts.behaviour) == (("own", "calm", "new"), ("success", "effort"))
    assert (found.facts.lower_is_better, found.facts.sources) == (("effort",), FACTS.sources | SCORES.facts.sources)
    assert found.facts.failures == FACTS.failures + SCORES.facts.failures
    for name, values in SCORES.known.items():
        np.testing.assert_array_equal(found[name], values)
    assert {name: (folder / name).read_bytes() for name in before} == before


def test_column_of_a_name_that_was_recorded_takes_its_place(folder):
    """Where it was computed by other code, or given up; its failure is gone then."""
    write_scores(folder / "scores-0.parquet", _paid("calm", np.full(STEPS, 9.0), Source("d" * 64, "mended")))
    found = read_recording(folder)
    assert found["reward/calm"].tolist() == [9.0] * STEPS
    assert (found.facts.rewards, found.facts.failures) == (("own", "calm"), ())
    assert found.facts.sources["reward/calm"].text == "mended"


def test_earlier_scores_stay(folder):
    """Those of other names; a name that both have is the later one's."""
    both = with_scores(SCORES, _paid("new", np.zeros(STEPS), Source("e" * 64, "newer")))
    assert (both["behaviour/effort"][0], both["reward/new"][0]) == (1, 0)
    assert (both.facts.sources["reward/new"].text, both.facts.lower_is_better) == ("newer", ("effort",))
    assert both.facts.failures == SCORES.facts.failures


def test_recording_that_went_on_is_not_scored_any_more(folder):
    """Nobody has paid its newest steps."""
    write_scores(folder / "scores-0.parquet", SCORES)
    writer = RecordingWriter(folder, FACTS, resume=True)
    writer.append([[4, 0, 1, 0, 1.0, 2.0, 0.0, False, False]])
    writer.close()
    assert read_recording(folder).facts.rewards == ("own", "calm")


def _damaged(path, how):
    if how == "cut off":
        path.write_bytes(path.read_bytes()[:-9])
        return
    table = pq.read_table(path)
    facts = json.loads(table.schema.metadata[b"harness"])
    facts |= {"newer": {"format": 2}, "no sources": {"sources": {}}}.get(how, {})
    if how == "infinite":
        table = table.set_column(0, "reward_new", pa.array(np.full(STEPS, np.inf)))
    if how == "another type":
        table = table.set_column(0, "reward_new", pa.array(range(STEPS)))
    if how == "another name":
        table = table.rename_columns(["terminated", "behaviour_effort"])
        facts["sources"]["terminated"] = facts["sources"]["reward_new"]
    if how == "more steps":
        table = pa.concat_tables([table, table])
    metadata = {} if how == "no facts" else {b"harness": json.dumps(facts)}
    pq.write_table(table.replace_schema_metadata(metadata), path)


@pytest.mark.parametrize(
    "how", ["cut off", "no facts", "no sources", "infinite", "another type", "another name", "more steps", "newer"]
)
def test_damaged_file_is_named(folder, how):
    """Each way in which it can be wrong."""
    write_scores(folder / "scores-0.parquet", SCORES)
    _damaged(folder / "scores-0.parquet", how)
    with pytest.raises(NewerFormat if how == "newer" else SchemaError, match=r"scores-0\.parquet"):
        read_recording(folder)
