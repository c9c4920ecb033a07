"""The trace: what is written is read again, in blocks of any size; what is no trace is refused."""

from functools import partial
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import harness.record.trace
from harness.errors import SchemaError, SimulationDiverged
from harness.files.parquet import require_room
from harness.log import Log
from harness.record.trace import (
    COLUMN,
    FLAGS,
    FORMAT,
    INTEGERS,
    NUMBERS,
    SCALARS,
    TraceWriter,
    read_trace,
    require_plausible,
    trace_schema,
)

DOF, ACTION_SIZE = 3, 2
WIDTH = len(SCALARS) + DOF + ACTION_SIZE
BLOCK = TraceWriter.BLOCK


def make_rows(count: int, first: int = 0) -> np.ndarray:
    """Rows that tell their number in every column; flags are on in every other one."""
    numbers = np.arange(first, first + count, dtype=float)
    rows = numbers[:, None] + np.arange(WIDTH) / 64.0
    for name in INTEGERS:
        rows[:, COLUMN[name]] = numbers
    for name in FLAGS:
        rows[:, COLUMN[name]] = numbers % 2
    return rows


def write(path: Path, *batches: np.ndarray, episodes: int | None = None) -> Log:
    """The trace of some batches of rows, read again."""
    with TraceWriter(path, DOF, ACTION_SIZE, episodes) as writer:
        for batch in batches:
            writer.append(batch)
    return read_trace(path)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Where a trace is written."""
    return tmp_path / "trace.parquet"


def test_every_number_comes_back(path: Path):
    """Each column holds what was appended, bit for bit."""
    rows = make_rows(5)
    trace = write(path, rows)
    for name, index in COLUMN.items():
        np.testing.assert_array_equal(trace[name], rows[:, index])
    np.testing.assert_array_equal(trace["qpos"], rows[:, len(SCALARS) : len(SCALARS) + DOF])
    np.testing.assert_array_equal(trace["action"], rows[:, len(SCALARS) + DOF :])


def test_columns_have_their_types(path: Path):
    """Counts are int32, flags bool, numbers float64."""
    trace = write(path, make_rows(2))
    for name in SCALARS:
        expected = np.int32 if name in INTEGERS else bool if name in FLAGS else np.float64
        assert trace[name].dtype == expected, name
    assert trace["qpos"].dtype == trace["action"].dtype == np.float64


def test_columns_are_those_of_the_schema(path: Path):
    """The file has the columns of `trace_schema`, in this order."""
    write(path, make_rows(1))
    assert pq.read_schema(path).equals(trace_schema(DOF, ACTION_SIZE))


def test_rows_are_copied(path: Path):
    """The caller may use the array of the rows again."""
    rows = make_rows(1)
    with TraceWriter(path, DOF, ACTION_SIZE) as writer:
        for number in range(3):
            rows[:] = make_rows(1, number)
            writer.append(rows)
    np.testing.assert_array_equal(read_trace(path)["env"], [0, 1, 2])


def test_blocks_do_not_show(path: Path, subtests: pytest.Subtests):
    """Rows arrive all, once and in order, however the batches fall on the writer's blocks."""
    rows = [
        (BLOCK,),
        (BLOCK - 1, 1),
        (BLOCK - 1, 2),
        (BLOCK, BLOCK),
        (BLOCK + 1,),
        (1, 2 * BLOCK + 3, 1),
        (2 * BLOCK,),
        (5, BLOCK, 5),
        (BLOCK // 2 + 1,) * 5,
        (0, 3, 0),
    ]
    for sizes in rows:
        with subtests.test(sizes=sizes):
            starts = np.cumsum((0, *sizes[:-1]))
            trace = write(path, *(make_rows(size, start) for size, start in zip(sizes, starts, strict=True)))
            np.testing.assert_array_equal(trace["env"], np.arange(sum(sizes)))
            np.testing.assert_array_equal(trace["distance"], make_rows(sum(sizes))[:, COLUMN["distance"]])


def test_only_the_first_episodes_are_kept(path: Path):
    """With `episodes` the rows of later ones are left out, also when a block holds nothing else."""
    rows = make_rows(3 * BLOCK)
    rows[:, COLUMN["episode"]] = np.arange(len(rows)) // 10
    trace = write(path, rows, episodes=2)
    np.testing.assert_array_equal(trace["env"], np.arange(20))


def test_trace_without_rows_is_a_trace(path: Path):
    """A trace may be empty: it has all columns, and no episode has ended."""
    trace = write(path)
    assert len(trace) == 0
    assert set(trace.columns) == {*SCALARS, "qpos", "action"}
    assert trace["qpos"].shape == (0, DOF)
    assert len(trace.last_rows) == 0


def test_trace_is_finished_when_its_writer_raises(path: Path):
    """What was appended before an error in the block of the writer is in the file."""

    def write_and_raise() -> None:
        with TraceWriter(path, DOF, ACTION_SIZE) as writer:
            writer.append(make_rows(4))
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        write_and_raise()
    assert len(read_trace(path)) == 4


def test_number_that_is_not_finite_is_told(path: Path, subtests: pytest.Subtests):
    """A number that is none costs the cell: the error names the column, and where it happened."""
    for number in [np.nan, np.inf, -np.inf]:
        for column, name in [(COLUMN["reward"], "reward"), (WIDTH - 1, "action")]:
            with subtests.test(number=number, column=column, name=name):
                rows = make_rows(9)
                rows[7, column] = number
                with pytest.raises(SimulationDiverged, match=f"{name} is not finite at env 7, episode 7, step 7"):
                    write(path, rows)


def test_number_that_is_too_large_costs_the_cell(path: Path):
    """A reader would call the file damaged: the training ends before that, and says why."""
    rows = make_rows(9)
    rows[7, SCALARS.index("reward")] = -1e200
    with pytest.raises(SimulationDiverged, match=r"reward is beyond 1e\+150 at env 7, episode 7, step 7"):
        write(path, rows)


@pytest.mark.parametrize(("rows", "most", "told"), [(0, 9, "has 0 rows"), (9, 8, "has 9 rows, 1 to 8 are allowed")])
def test_a_trace_that_no_cell_can_have_left_is_told_by_its_end(path: Path, rows: int, most: int, told: str):
    """Its rows are not read."""
    write(path, make_rows(rows))
    with pytest.raises(SchemaError, match=told):
        require_plausible(path, most)


def test_a_trace_that_a_cell_can_have_left_is_plausible(path: Path):
    """As many rows as it may have."""
    write(path, make_rows(9))
    require_plausible(path, 9)


def test_some_columns_can_be_read_alone(path: Path):
    """Reading some columns gives those, and the length."""
    write(path, make_rows(4))
    trace = read_trace(path, ["reward", "qpos"])
    assert set(trace.columns) == {"reward", "qpos"}
    assert len(trace) == 4


def test_last_rows_are_the_ends_of_episodes(path: Path):
    """An end is a row that is terminated or truncated: a target may be reached, or the arm held, on the way."""
    rows = make_rows(6)
    rows[:, [COLUMN[name] for name in FLAGS]] = 0.0
    flagged = ((0, "held"), (1, "terminated"), (1, "ground"), (2, "reached"), (3, "terminated"), (3, "reached"))
    for row, name in (*flagged, (4, "truncated")):
        rows[row, COLUMN[name]] = 1.0
    np.testing.assert_array_equal(write(path, rows).last_rows, [1, 3, 4])


def write_format_1(path: Path) -> None:
    """A trace of format 1, by hand: five steps, of which one reaches the target, one the ground, one the horizon."""
    flags = {
        "ground": [False, False, True, False, False],
        "reached": [False, True, False, False, False],
        "truncated": [False, False, False, False, True],
    }
    counts = {name: pa.array([0] * 5, pa.int32()) for name in INTEGERS}
    counts["step"] = pa.array(range(5), pa.int32())
    numbers = {name: pa.array([0.5] * 5) for name in NUMBERS}
    lists = {"qpos": pa.array([[0.1] * 3] * 5, pa.list_(pa.float64(), 3))}
    lists["action"] = pa.array([[0.2] * 2] * 5, pa.list_(pa.float64(), 2))
    table = pa.table({**counts, **numbers, **{name: pa.array(flag) for name, flag in flags.items()}, **lists})
    pq.write_table(table.replace_schema_metadata({b"harness.trace": b"1"}), path)


def test_format_1_is_read(path: Path):
    """Then both events ended an episode, and no arm was held; all columns of today are there."""
    write_format_1(path)
    trace = read_trace(path)
    assert set(trace.columns) == {*SCALARS, "qpos", "action"}
    np.testing.assert_array_equal(trace["terminated"], [False, True, True, False, False])
    assert not trace["held"].any()
    np.testing.assert_array_equal(trace.last_rows, [1, 2, 4])


def test_some_columns_of_format_1_are_read_alone(path: Path, subtests: pytest.Subtests):
    """Those that are asked for and no others, also where they follow from others."""
    rows = [
        ["terminated"],
        ["held", "reward"],
        ["reached", "terminated", "step"],
        ["reward"],
        ["ground", "qpos"],
        list(SCALARS),
    ]
    for columns in rows:
        with subtests.test(columns=columns):
            write_format_1(path)
            some, whole = read_trace(path, columns), read_trace(path)
            assert list(some.columns) == columns
            for name in columns:
                np.testing.assert_array_equal(some[name], whole[name])


def test_missing_column_of_format_1_is_refused(path: Path):
    """A column that neither format has is a SchemaError that names it."""
    write_format_1(path)
    with pytest.raises(SchemaError, match="no column colour"):
        read_trace(path, ["reward", "colour"])


@pytest.mark.parametrize("version", [str(FORMAT + 1), "0", "new"])
def test_other_format_is_refused(path: Path, version: str):
    """A trace of a newer format, or of none that ever was, is a SchemaError that names the file."""
    write_table(path, {b"harness.trace": version.encode()})
    with pytest.raises(SchemaError, match=r"trace\.parquet"):
        read_trace(path)


def test_parquet_of_somebody_else_is_refused(path: Path):
    """A Parquet file that is no trace is a SchemaError."""
    write_table(path, {})
    with pytest.raises(SchemaError, match=r"trace\.parquet"):
        read_trace(path)


def write_table(path: Path, metadata: dict[bytes, bytes]) -> None:
    """A Parquet file with the columns of a trace and other metadata."""
    table = trace_schema(DOF, ACTION_SIZE).empty_table().replace_schema_metadata(metadata)
    pq.write_table(table, path)


@pytest.mark.parametrize("share", [0.0, 0.3, 0.99])
def test_truncated_file_is_refused(path: Path, share: float):
    """A file that was cut off is a SchemaError that names it."""
    write(path, make_rows(100))
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    with pytest.raises(SchemaError, match=r"trace\.parquet"):
        read_trace(path)


def test_damaged_file_is_refused(path: Path):
    """A file whose data is not what was written is a SchemaError that names it."""
    write(path, make_rows(100))
    content = bytearray(path.read_bytes())
    content[40:240] = bytes(200)
    path.write_bytes(content)
    with pytest.raises(SchemaError, match=r"trace\.parquet"):
        read_trace(path).rows()


def test_a_file_that_was_replaced_is_refused(path: Path):
    """Its end was read when it was opened, and says nothing of the rows of another: they would be other numbers."""
    trace = write(path, make_rows(50))
    write(path.with_name("new"), make_rows(50, first=50)).facts.path.replace(path)
    with pytest.raises(SchemaError, match=r"trace\.parquet was replaced since it was opened: type the command again"):
        trace["distance"]


def test_missing_file_is_refused(path: Path):
    """A file that is not there is a SchemaError that names it."""
    with pytest.raises(SchemaError, match=r"trace\.parquet"):
        read_trace(path)


def test_format_1_without_its_flags_is_refused(path: Path):
    """What such a file lacks follows from them, so they are needed whatever is asked for."""
    table = pa.table({"reward": [1.0]}).replace_schema_metadata({b"harness.trace": b"1"})
    pq.write_table(table, path)
    with pytest.raises(SchemaError, match="no column ground, reached"):
        read_trace(path)


def test_missing_column_is_refused(path: Path):
    """A trace that lacks a column that is asked for is a SchemaError that names the file."""
    table = pa.table({"reward": [1.0]}).replace_schema_metadata({b"harness.trace": str(FORMAT).encode()})
    pq.write_table(table, path)
    with pytest.raises(SchemaError, match=r"trace\.parquet"):
        read_trace(path, ["reward", "distance"])


def test_extra_columns_stand_behind_the_others(path: Path):
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
    assert not read_trace(path, ["reward", "obstacle"])["obstacle"].any()


def test_rows_times_columns_are_bounded_before_they_are_read(path: Path, monkeypatch: pytest.MonkeyPatch):
    """A file of a mebibyte may tell of 24 gigabytes."""
    write(path, make_rows(3))
    monkeypatch.setattr(harness.record.trace, "require_room", partial(require_room, most=10))
    with pytest.raises(SchemaError, match=r"it has 3 rows of \d+ numbers, 10 are allowed"):
        read_trace(path)
    read_trace(path, ["reward", "distance"])
