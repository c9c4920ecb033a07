"""Recorded files of anybody: what each row says, and what is said about a file that cannot be read."""

import os

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from harness.errors import SchemaError, UsageError
from harness.record import TraceWriter
from harness.record.cell_log import cell_of
from harness.registry import Choice
from harness.score.csv_steps import EVENTS, PAY, STEPS, StepsCsv
from harness.score.open_steps import match_steps, open_steps
from harness.score.scorer import can_be_paid, pay_log
from harness_plugins.rewards.relative import Relative
from tests.refusals import refused

HEADER = "t,beginDistance,prevBest,distance,delta_distance,reward,target x,endEff x ,endEff z "
BASE = (
    ",1.11,1.11,1.11,0,0,1,2,3",
    ",1.11,1.11,0.5,,0.61,1,2,3",
    ",1.11,0.5,0.5,,0.61,1,2,3",
    ",1.11,0.5,0.7500001,,-0.2500001,1,2,3",
    ",0.9,0.9,0.8,,0.1,1,2,3",  # the target was touched and drawn again
    ",1.11,1.11,1.11,0,0,1,2,3",
    ",1.11,1.11,1.11,,0,1,2,3",  # stood still: no episode's start
)
K2 = (
    "0,1.11,1.11,1.11,0,0,1,2,3",
    "1,1.11,0.5,0.5,-0.61,0.915,1,2,3",
    "2,1.11,0.5,0.5,0,0.915,1,2,3",
    "3,1.11,0.5,0.75,0.25,-0.25,1,2,3",
    "4,0.9,0.8,0.8,-0.1,0.15,1,2,3",
    "0,1.11,1.11,1.11,0,0,1,2,3",
    "1,1.11,1.11,1.11,0,0,1,2,3",
)
BEFORE = [1.11, 1.11, 0.5, 0.5, 0.9, 1.11, 1.11]
DELTA = [0.0, -0.61, 0.0, 0.25, -0.1, 0.0, 0.0]
START = [True, False, False, False, False, True, False]


@pytest.fixture
def write(tmp_path):
    """Write lines to a file."""

    def write_lines(*lines, name="run.csv", end="\r\n"):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("".join(line + end for line in lines), newline="")
        return path

    return write_lines


def rows_of(path):
    """All rows of a file."""
    return open_steps(path).rows()


@pytest.mark.parametrize("rows", [BASE, K2, [*BASE, *K2, *BASE]], ids=["base line", "K2", "joined"])
def test_both_programs_files_say_the_same(write, rows):
    """The same steps, written by either program, have the same starts, best distances before the step and Dd.

    What is filled in decides row by row, so that no file has to be of one program.
    """
    read, times = open_steps(write(HEADER, *rows)), len(rows) // len(BASE)
    told = {name: read[name] for name in STEPS}
    for name, values, tolerance in (
        ("start", START, 0.0),
        ("previous_best", BEFORE, 1e-12),
        ("delta_distance", DELTA, 2e-7),
        ("step", [0, 1, 2, 3, 4, 0, 1], 0.0),
        ("begin_distance", [1.11, 1.11, 1.11, 1.11, 0.9, 1.11, 1.11], 0.0),
        ("distance", [1.11, 0.5, 0.5, 0.75, 0.8, 1.11, 1.11], 2e-7),
    ):
        np.testing.assert_allclose(told[name], times * values, atol=tolerance, rtol=0.0)
    assert read.facts.first_line == 2
    assert not {*EVENTS} & {*read.columns}


@pytest.mark.parametrize("rows", [1, 2, 3, 6, 7, 100])
def test_pieces_of_any_size_hold_the_same_rows(write, rows):
    """Pieces are as long as asked for, the last one apart, and together say what one says."""
    path = write(HEADER, *BASE, *K2)
    whole, pieces = rows_of(path), list(open_steps(path).pieces((PAY, *STEPS), rows))
    assert {len(piece) for piece in pieces[:-1]} <= {rows}
    assert [piece.first for piece in pieces] == list(range(0, 14, rows))
    for name in (PAY, *STEPS):
        np.testing.assert_array_equal(np.concatenate([piece[name] for piece in pieces]), whole[name])


def test_numbers_are_read_as_c_sharp_prints_them(write):
    """Exponents, signs and blanks around a number; every digit counts."""
    values = ["1.192093E-07", "-1.384625E-05", "+2", " 3 ", "4e2", "-0", ".5", "0.1234567890123456"]
    rows = rows_of(write("a,reward", *(f",{value}" for value in values)))
    np.testing.assert_array_equal(rows[PAY], [float(value) for value in values])


@pytest.mark.parametrize("header", ["Reward", " reward ", "REWARD", '"reward"', "\ufeffreward"])
def test_column_names_are_trimmed_and_in_any_case(write, header):
    """A file with nothing but rewards is a log; it has no other column."""
    rows = rows_of(write(header, "1.5", "", "-2", end="\n"))
    np.testing.assert_array_equal(rows[PAY], [1.5, -2.0])
    assert {*rows.columns} == {PAY}


def test_a_last_line_without_its_end_is_read(write):
    """And told, for its number may have lost digits. So are the lines of Windows and of Unix."""
    path = write("reward", "1", end="\n")
    path.write_text(path.read_text() + "2")
    log = open_steps(path)
    np.testing.assert_array_equal(log[PAY], [1.0, 2.0])
    assert log.facts.notes == ("the last line does not end: it may be cut off",)
    assert open_steps(write("reward", "1")).facts.notes == ()


def test_distances_that_do_not_suffice_are_not_read(write):
    """Without a best distance nothing can be scored again: such columns may hold anything."""
    log = open_steps(write("t,distance,beginDistance,reward", "noon,far,,1"))
    assert log.columns == (PAY,)
    assert not can_be_paid(log)
    np.testing.assert_array_equal(log[PAY], [1.0])


def test_episodes_are_counted_in_each_env(write):
    """From 0, by their start rows; where the first is missing the rows before the next one are the first episode."""
    rows = ["0,0,1,1,1,0", "1,1,1,1,0.5,0.5", "0,1,1,1,0.5,0.5", "1,0,1,1,1,0", "0,0,1,1,1,0", "1,1,1,1,0.5,0.5"]
    read = rows_of(write("env,t,beginDistance,prevBest,distance,reward", *rows))
    np.testing.assert_array_equal(read["episode"], [0, 0, 0, 1, 1, 1])


@pytest.mark.parametrize(("cells", "known"), [(("0", "1"), True), (("False", "True"), False), (("", ""), False)])
def test_ends_of_episodes_are_read_where_they_are_told_in_numbers(write, cells, known):
    """Other words are left unread, and keep nobody from reading the file."""
    header = "t,beginDistance,prevBest,distance,reward,terminated,truncated"
    log = open_steps(write(header, f"0,1,1,1,0,{cells[0]},{cells[0]}", f"1,1,1,0.5,0.5,{cells[0]},{cells[1]}"))
    assert [name in log for name in ("terminated", "truncated", "reached")] == [known, known, False]
    if known:
        np.testing.assert_array_equal(log["truncated"], [False, True])
        assert log["truncated"].dtype == bool


def test_a_touched_target_is_read_of_a_file(write):
    """The next target may be as far away as the last one was: the distance before the step is the new one's."""
    header = "t,beginDistance,prevBest,distance,reward,reached,terminated,truncated"
    rows = ["0,1,1,1,0,0,0,0", "1,1,1,0.1,0.9,1,0,0", "2,1,1,0.8,0.2,0,0,0"]
    told = write(header, *rows)
    bare = write(header.partition(",reached")[0], *(row[:-6] for row in rows), name="bare.csv")
    relative = Relative()
    np.testing.assert_allclose(pay_log(relative, open_steps(told)).total, [0.0, 0.9, 0.2])
    np.testing.assert_allclose(pay_log(relative, open_steps(bare)).total, [0.0, 0.9, -0.7 / 0.8])


@pytest.mark.parametrize(
    ("rows", "is_ours"),
    [
        (["t,reward", "0,0", "1,0.5", "2,0.5"], True),
        (["reward", "1"], True),
        (["episode,reward,length", "0,-19,200", "1,-18,200", "2,-17,150"], False),
        (["r,l,t", "-19.8,200,0.0"], False),
        (["step,reward", "0,1", "1000,2"], True),
        (["step,reward", "0,NaN", "1,2"], True),
        (["id,reward,seed,steps", "ca8d,sparse,0,3000", "9a17,dense,0,3000"], False),
    ],
    ids=["steps", "a row", "episodes", "Monitor", "rows are missing", "not a number", "our own table of cells"],
)
def test_the_format_recognises_tables_of_steps(write, rows, is_ours):
    """And leaves tables of episodes to others; what is missing is told where the rows are read."""
    path = write(*rows)
    assert StepsCsv().recognises(path, path.read_bytes()) is is_ours


def test_either_column_gives_the_best_distance(write):
    """Of delta_distance and prevBest one is enough; without t the starts are told by their rows."""
    best = rows_of(write("beginDistance,prevBest,distance,reward", "1,1,1,0", "1,1,0.5,0.5", "1,0.5,0.75,-0.25"))
    delta = rows_of(write("beginDistance,delta_distance,distance,reward", "1,0,1,0", "1,-0.5,0.5,0.5", "1,0.25,0.75,1"))
    for rows in (best, delta):
        np.testing.assert_array_equal(rows["previous_best"], [1.0, 1.0, 0.5])
        np.testing.assert_array_equal(rows["delta_distance"], [0.0, -0.5, 0.25])
        np.testing.assert_array_equal(rows["start"], [True, False, False])


def test_steps_are_counted_from_the_last_start(write):
    """Where the file does not count; a file of megabytes is read in blocks, and an episode goes on through all."""
    far = [",1,1,2,,-1"] * 200_000
    path = write("t,beginDistance,prevBest,distance,delta_distance,reward", *far[:2], ",1,1,1,0,0", *far)
    np.testing.assert_array_equal(open_steps(path)["step"], [1, 2, *range(200_001)])


# Traces


ROWS = {
    "env": [0, 0, 0],
    "step": [0, 1, 2],
    "begin_distance": [1.0, 1.0, 1.0],
    "previous_best": [1.0, 1.0, 0.6],
    "distance": [1.0, 0.6, 0.7],
    "delta_distance": [0.0, -0.4, 0.7 - 0.6],
    "reward": [0.0, 0.4, -(0.7 - 0.6)],
    "reward_ground": [0.0, 0.0, -1.0],
    "reward_target": [0.0, 1.0, 0.0],
    "reward_step": [0.0, -0.25, -0.25],
}
"""Of a trace with one joint: start, closer, farther, with event terms."""


@pytest.fixture
def trace(tmp_path, write_trace):
    """A trace with its manifest."""
    reward = Choice("arp", (("k1", 1.0), ("k2", 2.0)), "arp:k2=2")
    return write_trace(tmp_path, ROWS, reward=reward, seed=7)


def test_a_trace_is_read_as_it_is(trace):
    """Its best distance is the one before the step, exactly; so are its event terms."""
    rows = rows_of(trace)
    for name in ("previous_best", "delta_distance", "reward_target", "reward_step", "step", "env"):
        np.testing.assert_array_equal(rows[name], ROWS[name])
    assert open_steps(trace).facts.first_line == 1


def test_a_trace_declares_its_reward(trace):
    """The manifest beside it says what paid it, and its seed; without a manifest nothing is said."""
    log = open_steps(trace)
    assert (log.facts.trained_with, log.facts.seed) == ("arp:k2=2", 7)
    assert cell_of(trace).reward == Choice("arp", (("k1", 1.0), ("k2", 2.0)), "arp:k2=2")
    (trace.parent / "manifest.json").unlink()
    log = open_steps(trace)
    assert (log.facts.trained_with, log.facts.seed, cell_of(trace)) == ("", None, None)


def test_a_trace_as_csv_is_read_as_the_trace(trace, write):
    """A trace's own column names mean in a CSV file what they mean in a trace."""
    lines = [",".join(map(str, row)) for row in zip(*ROWS.values(), strict=True)]
    from_csv, from_trace = rows_of(write(",".join(ROWS), *lines)), rows_of(trace)
    for name in (*EVENTS, *STEPS[1:]):
        np.testing.assert_array_equal(from_csv[name], from_trace[name])
    np.testing.assert_array_equal(from_csv[PAY], from_trace["reward/arp:k2=2"])


# Files that cannot be read


def refuse(path, told, kind=UsageError):
    """One line that says this of the file."""
    with pytest.raises(kind) as refused:
        rows_of(path)
    line = str(refused.value)
    assert str(path) in line
    assert told in line
    assert "\n" not in line
    assert len(line) < 300 + len(str(path))


FULL = "t,beginDistance,prevBest,distance,delta_distance,reward"
ROW = "0,1,1,1,0,0"


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        (["a,reward", "1,2", "1,-inf"], "line 3, column 'reward': '-inf' is no finite number"),
        (["a,reward", "1,1e400"], "line 2, column 'reward': '1e400' is no finite number"),
        (["a, Reward ", "1,2", "1,none"], "line 3, column 'Reward': 'none' is no finite number"),
        (["a,reward", "1,2", "1,"], "line 3, column 'reward': the cell is empty"),
        (["a,reward", "1,2", "", "1, "], "line 4, column 'reward': the cell is empty"),
        (
            ["a,reward", '1,"1,234.5"'],
            "line 2, column 'reward': '1,234.5' is no finite number: write decimal points",
        ),
        (
            ["a,reward", "1,2", "1,1,234.5"],
            "line 3, column 3: cells in the line: 3, in the header: 2; a comma inside",
        ),
        (["a,reward", "1,2", "1"], "line 3, column 'reward': cells in the line: 1, in the header: 2"),
        (["a;reward", "1;2"], "line 1: no column 'reward': the columns are separated by semicolons"),
        (["a\treward", "1\t2"], "line 1: no column 'reward': the columns are separated by tabs"),
        (["a,b", "1,2"], "line 1: no column 'reward'; there is: a, b"),
        (["a;,b", "1,2"], "line 1: no column 'reward'; there is: a;, b"),
        (["time,reward_own", "1,2"], "Call the one that taught 'reward', such as 'reward_own'"),
        (["reward,b,Reward"], "line 1: two columns are called 'reward'"),
        ([], " is empty"),
        ([""], "line 1: no column 'reward'; there is: nothing"),
        (["a,reward"], " has no rows"),
        ([FULL, ROW, "1,1,1,,0,1"], "line 3, column 'distance': the cell is empty"),
        ([FULL, ROW, ",1,,1,,1"], "line 3, column 'prevBest': the cell is empty"),
        ([FULL, ROW, "later,1,1,1,,1"], "line 3, column 't': 'later' is no finite number"),
        (
            ["beginDistance,delta_distance,distance,reward", "1,,1,1"],
            "line 2, column 'delta_distance': the cell is empty",
        ),
        (["reward", *["1"] * 400_000, "x"], "line 400002, column 'reward': 'x' is no finite number"),
        (["reward" + ",a" * 1_000, "1" * 1_001], "line 1: 1,001 columns, 1,000 are allowed"),
        (["reward", "1" * 300_000], "a line has more than 262,144 characters"),
        (["reward," + "a" * 300_000, "1,2"], "a line has more than 262,144 characters"),
        (['reward,"' + "a" * 200_000 + '"', "1,2"], "field larger than field limit"),
        (["reward", "1" * 100_000 + "x"], "is no finite number"),
        (["reward", "1e300"], "'1e300' is no finite number"),
        (["reward", "1\0"], "is no finite number"),
        (["t,beginDistance,prevBest,distance,reward", "1e20,1,1,1,1"], "too large"),
    ],
)
def test_a_fault_is_told_in_one_line(write, lines, told):
    """File, line and column of the first fault, wherever in the file it is; the line is short, whatever the cell."""
    refuse(write(*lines), told)


def test_a_file_of_too_many_rows_is_refused(write, monkeypatch):
    """A table ends somewhere."""
    monkeypatch.setattr("harness.log.log.MOST_ROWS", 4)
    refuse(write("reward", *"12345"), "has more than the 4 rows that are allowed", SchemaError)


@pytest.mark.parametrize(
    ("values", "version", "told"),
    [
        *(([it], b"1", "") for it in ("a", [1.0], None, 1e300)),
        *(([1.0], version, "") for version in (b"x", b"\xff", b"9" * 5_000)),
        ([1.0], None, ".parquet is a Parquet file, and no trace: "),
        ([1.0], None, " there is: reward"),
    ],
)
def test_a_table_that_is_no_trace_is_refused(tmp_path, values, version, told):
    """Whatever pyarrow or Python says of it, a damaged one in any case."""
    path = tmp_path / "a.parquet"
    metadata = {} if version is None else {b"harness.trace": version}
    pq.write_table(pa.table({"reward": values}).replace_schema_metadata(metadata), path)
    refuse(path, told, SchemaError)
    path.write_bytes(path.read_bytes()[:20])
    refuse(path, "a.parquet is no readable trace", SchemaError)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes in the file system")
def test_what_has_no_rows_to_read_is_refused(tmp_path):
    """A spreadsheet's UTF-16 as such, a run that ended before its first step, a file of 10 TB at once, and a pipe."""
    (tmp_path / "wide.csv").write_text("reward\n1\n", encoding="utf-16")
    TraceWriter(tmp_path / "trace.parquet", 1, 1).close()
    with (tmp_path / "run.csv").open("wb") as file:
        file.truncate(10**13)
    os.mkfifo(tmp_path / "pipe.csv")
    for name, told in {
        "gone.csv": "gone.csv cannot be read: No such file",
        "wide.csv": "is text in UTF-16: save it as UTF-8",
        "trace.parquet": "trace.parquet has no rows",
        "run.csv": "it has 10,000,000,000,000 bytes, 8,589,934,592 are allowed",
        "pipe.csv": "it is no regular file",
    }.items():
        refuse(tmp_path / name, told)


# Patterns


def _names(logs):
    return [log.facts.path.name for log in logs]


def test_patterns_match_files_sorted_each_once(write, tmp_path):
    """``**`` stands for any folders, folders are left out, and a file that two patterns match is one run.

    ``run[1].csv`` is the file of that name where there is one.
    """
    for name in ("b.csv", "deep/er/a.csv", "deep/c.csv", "notes.txt"):
        write("reward", "1", name=name)
    (tmp_path / "folder.csv").mkdir()
    assert _names(match_steps(f"{tmp_path}/**/*.csv")) == ["b.csv", "c.csv", "a.csv"]
    both = [f"{tmp_path}/*.csv", f"{tmp_path}/b*", f"{tmp_path}/deep/*.csv"]
    assert _names(match_steps(both)) == ["b.csv", "c.csv"]
    assert _names(match_steps(str(write("reward", "1", name="run[1].csv")))) == ["run[1].csv"]


def test_a_pattern_without_a_file_is_told(write, tmp_path):
    """Each of several patterns has to match a file; folders alone are named as the reason."""
    write("reward", "1")
    with refused(r"No file matches '.*/\*\.tsv'\. Quote"):
        match_steps([f"{tmp_path}/*.csv", f"{tmp_path}/*.tsv"])
    with refused("it matches folders only"):
        match_steps(str(tmp_path))


@pytest.mark.parametrize("pattern", ["~nobody-of-this-name/*.csv", "x" * 5_000, "a\0b", "["])
def test_a_pattern_that_no_name_can_be_matches_nothing(pattern):
    """Whatever the system says of it."""
    with refused("No file matches|No folder or file"):
        match_steps(pattern)
