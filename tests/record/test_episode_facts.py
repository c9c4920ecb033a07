"""What is known of a trace's episodes beside its rows: written with them, read with them."""

import pyarrow.parquet as pq
import pytest

from harness.errors import SchemaError
from harness.log import episode_facts
from harness.record import EpisodeFacts, TraceWriter, read_trace

FACTS = EpisodeFacts(horizon=100, control_period=0.1, ik_steps=(3, None, 5), work=(1.5, 0.0, 2.25))


def test_facts_come_back_with_the_trace(tmp_path):
    """Every one, whatever columns are read."""
    with TraceWriter(tmp_path / "trace.parquet", 3, 2, facts=FACTS):
        pass
    assert episode_facts(read_trace(tmp_path / "trace.parquet")) == FACTS
    assert episode_facts(read_trace(tmp_path / "trace.parquet")) == FACTS


def test_facts_may_become_known_while_rows_are_written(tmp_path):
    """What the writer holds at the end is what the file tells."""
    with TraceWriter(tmp_path / "trace.parquet", 3, 2) as writer:
        writer.facts = FACTS
    assert episode_facts(read_trace(tmp_path / "trace.parquet")) == FACTS


def _write(path, metadata):
    """A trace whose metadata tell something else."""
    with TraceWriter(path, 3, 2):
        pass
    table = pq.read_table(path)
    pq.write_table(table.replace_schema_metadata({b"harness.trace": b"2", **metadata}), path)


def test_file_of_an_earlier_version_tells_nothing(tmp_path):
    """It has no such metadata; its rows are read."""
    _write(tmp_path / "trace.parquet", {})
    assert episode_facts(read_trace(tmp_path / "trace.parquet")) == EpisodeFacts()


def test_facts_of_a_newer_version_are_left_out():
    """What this version knows is read."""
    assert EpisodeFacts.from_bytes(b'{"horizon": 7, "wind": 3.0}') == EpisodeFacts(horizon=7)


@pytest.mark.parametrize(
    "facts",
    [
        EpisodeFacts(7, 0.5, error="tilt", unit="rad", target_moves=False),
        EpisodeFacts(7, 0.5, arms=(((1.0, 0.9), (1.1, 1.0), 1.0), ((1.2, 1.0), (1.0, 1.0), 0.5))),
    ],
    ids=["a goal", "varied arms"],
)
def test_facts_come_back_from_their_bytes(facts):
    """Error, unit and whether the target of a goal moves; the factors of each arm, nested as they were."""
    assert EpisodeFacts.from_bytes(facts.to_bytes()) == facts


@pytest.mark.parametrize("written", [b"{", b"[1]", b"\xff"])
def test_damaged_facts_are_refused(tmp_path, written):
    """The trace that holds them is a SchemaError that names it."""
    _write(tmp_path / "trace.parquet", {b"harness.facts": written})
    with pytest.raises(SchemaError, match=r"trace\.parquet"):
        read_trace(tmp_path / "trace.parquet")
