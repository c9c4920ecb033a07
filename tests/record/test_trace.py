"""The trace: what is written is read again, in blocks of any size; what is no trace is refused."""

import re
import shutil
import threading

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import harness.record.trace
from harness.errors import SchemaError, SimulationDiverged
from harness.record import COLUMN, SCALARS, EpisodeFacts, TraceWriter, read_trace
from harness.record.parts import PART_ROWS

DOF, ACTION_SIZE = 3, 2
WIDTH = len(SCALARS) + DOF + ACTION_SIZE
BLOCK = PART_ROWS
INTEGERS, FLAGS = ("env", "episode", "step"), ("ground", "reached", "held", "terminated", "truncated")


def make_rows(count, first=0):
    """Rows that tell their number in every column; flags are on in every other one."""
    numbers = np.arange(first, first + count, dtype=float)
    rows = numbers[:, None] + np.arange(WIDTH) / 64.0
    for name in INTEGERS:
        rows[:, COLUMN[name]] = numbers
    for name in FLAGS:
        rows[:, COLUMN[name]] = numbers % 2
    return rows


def write(path, *batches):
    """The trace of some batches of rows, read again."""
    with TraceWriter(path, DOF, ACTION_SIZE) as writer:
        for batch in batches:
            writer.append(batch)
    return read_trace(path)


@pytest.fixture
def path(tmp_path):
    """Where a trace is written."""
    return tmp_path / "trace.parquet"


def test_every_number_comes_back(path):
    """Each column holds what was appended, bit for bit; counts are int32, flags bool, numbers float64."""
    rows = make_rows(5)
    trace = write(path, rows)
    for name, index in COLUMN.items():
        np.testing.assert_array_equal(trace[name], rows[:, index])
        assert trace[name].dtype == (np.int32 if name in INTEGERS else bool if name in FLAGS else np.float64), name
    for name, part in (("qpos", slice(-5, -2)), ("action", slice(-2, None))):
        np.testing.assert_array_equal(trace[name], rows[:, part])
        assert trace[name].dtype == np.float64
    assert pq.read_schema(path).names == [*SCALARS, "qpos", "action"]


def test_rows_are_copied(path):
    """The caller may use the array of the rows again."""
    rows = make_rows(1)
    with TraceWriter(path, DOF, ACTION_SIZE) as writer:
        for number in range(3):
            rows[:] = make_rows(1, number)
            writer.append(rows)
    np.testing.assert_array_equal(read_trace(path)["env"], [0, 1, 2])


SIZES = [
    (BLOCK,), (BLOCK - 1, 1), (BLOCK - 1, 2), (BLOCK, BLOCK), (BLOCK + 1,), (1, 2 * BLOCK + 3, 1), (2 * BLOCK,),
    (5, BLOCK, 5), (BLOCK // 2 + 1,) * 5, (0, 3, 0),
]  # fmt: skip


@pytest.mark.parametrize("sizes", SIZES, ids=str)
def test_blocks_do_not_show(path, sizes):
    """Rows arrive all, once and in order, however the batches fall on the writer's blocks."""
    starts = np.cumsum((0, *sizes[:-1]))
    trace = write(path, *(make_rows(size, start) for size, start in zip(sizes, starts, strict=True)))
    np.testing.assert_array_equal(trace["env"], np.arange(sum(sizes)))
    np.testing.assert_array_equal(trace["distance"], make_rows(sum(sizes))[:, COLUMN["distance"]])


def test_trace_without_rows_is_a_trace(path):
    """A trace may be empty: it has all columns, and no episode has ended."""
    trace = write(path)
    assert (len(trace), len(trace.last_rows), trace["qpos"].shape) == (0, 0, (0, DOF))
    assert set(trace.columns) == {*SCALARS, "qpos", "action"}


def test_trace_is_finished_when_its_writer_raises(path):
    """What was appended before an error in the block of the writer is in the file."""
    with pytest.raises(ZeroDivisionError), TraceWriter(path, DOF, ACTION_SIZE) as writer:  # noqa: PT012
        writer.append(make_rows(4))
        raise ZeroDivisionError
    assert len(read_trace(path)) == 4


@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf, -1e200])
def test_number_that_no_reader_takes_costs_the_cell(path, number):
    """The training ends there, and says in which column, and where it happened."""
    for column, name in [(COLUMN["reward"], "reward"), (WIDTH - 1, "action")]:
        rows = make_rows(9)
        rows[7, column] = number
        told = re.escape(f"{name} is {number:g}, no number within 1e+150, at env 7, episode 7, step 7")
        with pytest.raises(SimulationDiverged, match=told):
            write(path, rows)


def test_last_rows_are_the_ends_of_episodes(path):
    """An end is a row that is terminated or truncated: a target may be reached, or the arm held, on the way."""
    rows = make_rows(6)
    rows[:, [COLUMN[name] for name in FLAGS]] = 0.0
    flagged = ((0, "held"), (1, "terminated"), (1, "ground"), (2, "reached"), (3, "terminated"), (3, "reached"))
    for row, name in (*flagged, (4, "truncated")):
        rows[row, COLUMN[name]] = 1.0
    np.testing.assert_array_equal(write(path, rows).last_rows, [1, 3, 4])


@pytest.fixture
def old(path):
    """A trace of format 1, by hand: five steps, of which one reaches the target, one the ground, one the horizon."""
    columns = {name: pa.array([0.5] * 5) for name in SCALARS if name not in FLAGS}
    columns |= {name: pa.array([0] * 5, pa.int32()) for name in INTEGERS} | {"step": pa.array(range(5), pa.int32())}
    columns |= {name: pa.array(np.arange(5) == row) for name, row in (("ground", 2), ("reached", 1), ("truncated", 4))}
    columns |= {
        name: pa.array([[0.1] * size] * 5, pa.list_(pa.float64(), size)) for name, size in (("qpos", 3), ("action", 2))
    }
    pq.write_table(pa.table(columns).replace_schema_metadata({b"harness.trace": b"1"}), path)
    return path


def test_format_1_is_read(old):
    """Then both events ended an episode, and no arm was held; all columns of today are there."""
    trace = read_trace(old)
    assert set(trace.names) == {*SCALARS, "qpos", "action", "obstacle"}
    np.testing.assert_array_equal(trace["terminated"], [False, True, True, False, False])
    assert not trace["held"].any()
    np.testing.assert_array_equal(trace.last_rows, [1, 2, 4])


def _told(path, metadata):
    write(path, make_rows(1))
    pq.write_table(pq.read_table(path).replace_schema_metadata(metadata), path)


def _short(path, version):
    pq.write_table(pa.table({"reward": [1.0]}).replace_schema_metadata({b"harness.trace": version}), path)


def _cut(path, share):
    write(path, make_rows(100))
    path.write_bytes(path.read_bytes()[: int(share * path.stat().st_size)])


def _zeroed(path):
    write(path, make_rows(100))
    content = path.read_bytes()
    path.write_bytes(content[:40] + bytes(200) + content[240:])


REFUSED = {
    "a newer format": lambda path: _told(path, {b"harness.trace": b"4"}),
    "a format that never was": lambda path: _told(path, {b"harness.trace": b"0"}),
    "no format": lambda path: _told(path, {b"harness.trace": b"new"}),
    "somebody else's": lambda path: _told(path, {}),
    "empty": lambda path: _cut(path, 0.0),
    "cut off": lambda path: _cut(path, 0.3),
    "its end cut off": lambda path: _cut(path, 0.99),
    "other data": _zeroed,
    "missing": lambda path: None,
    "no column ground, reached": lambda path: _short(path, b"1"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_is_no_trace_is_refused(path, what):
    """It is a SchemaError that names the file, or what format 1 lacks of its flags."""
    REFUSED[what](path)
    with pytest.raises(SchemaError, match=what if what.startswith("no column") else r"trace\.parquet"):
        read_trace(path).rows()


def test_a_trace_that_was_replaced_is_that_which_was_opened(path):
    """The rows of another one are never mixed with its own; of several files, the full ones are refused."""
    for count in (50, PART_ROWS + 1):
        trace = write(path, make_rows(count))
        assert trace["env"][0] == 0
        write(path.with_name("new"), make_rows(count, first=50)).facts.path.replace(path)
        if count == 50:
            np.testing.assert_array_equal(trace["distance"], make_rows(count)[:, COLUMN["distance"]])
            continue
        with pytest.raises(SchemaError, match=r"trace\.parquet was replaced since it was opened: type the command"):
            trace["distance"]


def test_extra_columns_stand_behind_the_others(path):
    """Each with its type; a trace without them tells that nothing was touched, also where that alone is asked for."""
    extras = {"arm": 1, "obstacle": 1, "obstacles": 14}
    rows = np.concatenate([make_rows(3), np.arange(48.0).reshape(3, 16)], axis=1)
    with TraceWriter(path, DOF, ACTION_SIZE, extras=extras) as writer:
        writer.append(rows)
    trace = read_trace(path)
    assert list(trace.columns)[-3:] == list(extras)
    np.testing.assert_array_equal(trace["arm"], [0, 16, 32])
    np.testing.assert_array_equal(trace["obstacle"], [True, True, True])
    np.testing.assert_array_equal(trace["obstacles"], rows[:, -14:])
    np.testing.assert_array_equal(trace["action"], rows[:, WIDTH - ACTION_SIZE : WIDTH])
    write(path, make_rows(3))
    assert not read_trace(path)["obstacle"].any()


def test_rows_times_columns_are_bounded_before_they_are_read(path, monkeypatch):
    """A file of a mebibyte may tell of 24 gigabytes."""
    write(path, make_rows(3))
    monkeypatch.setattr(harness.record.trace, "MOST_NUMBERS", 10)
    with pytest.raises(SchemaError, match=r"it has 3 rows of \d+ numbers, 10 are allowed"):
        read_trace(path)


def test_whoever_reads_while_it_grows_sees_a_whole_trace(path):
    """However often, and in the middle of anything: the rows from the first on, never fewer than before."""
    writer, seen = TraceWriter(path, DOF, ACTION_SIZE), [0]

    def grow():
        for number in range(400):
            writer.append(make_rows(1, number))
            writer.keep()

    writer.keep()
    growing = threading.Thread(target=grow)
    growing.start()
    while growing.is_alive():
        found = read_trace(path).rows(["env", "qpos"])
        np.testing.assert_array_equal(found["env"], np.arange(len(found["env"])))
        assert seen[-1] <= len(found["env"]) == len(found["qpos"])
        seen.append(len(found["env"]))
    assert len({*seen}) > 2


def test_part_of_another_trace_is_refused(tmp_path):
    """One that is not full, or of which something else is known."""
    for name, rows, horizon in (("one", PART_ROWS + 1, 5), ("other", PART_ROWS + 1, 6), ("short", 9, 5)):
        with TraceWriter(tmp_path / f"{name}.parquet", DOF, ACTION_SIZE, EpisodeFacts(horizon)) as writer:
            writer.append(make_rows(rows))
    read_trace(tmp_path / "one.parquet")
    for name in ("other", "short"):
        shutil.copy(tmp_path / "one-00001.parquet", tmp_path / f"{name}-00001.parquet")
        with pytest.raises(SchemaError, match=rf"{name}\.parquet is no part of the trace that ends with {name}-00001"):
            read_trace(tmp_path / f"{name}.parquet")
