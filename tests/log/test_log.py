"""A log: its rows in pieces, whole and in part; columns that are kept; episodes of steps."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from harness.errors import SchemaError
from harness.log import Log, LogFacts, in_memory
from harness.log.log import episode_rows
from tests.refusals import refused

FACTS = LogFacts(path=Path("runs/a.log"), format="made up")


class Source:
    """Gives ten rows in tables of three, and remembers what it was asked."""

    def __init__(self, rows: int = 10) -> None:
        self.rows, self.asked = rows, list[tuple[str, ...]]()

    def __call__(self, names):
        """Column ``a`` counts rows, ``b`` tens of them."""
        self.asked.append(names)
        whole = {"a": np.arange(self.rows), "b": 10 * np.arange(self.rows)}
        for first in range(0, self.rows, 3):
            yield {name: whole[name][first : first + 3] for name in names}


@pytest.fixture(name="source")
def _source():
    return Source()


@pytest.fixture(name="log")
def _log(source):
    return Log(FACTS, ("a", "b"), source)


@pytest.mark.parametrize("rows", [1, 2, 3, 4, 7, 10, 100])
def test_pieces_are_all_rows_in_order(log, rows):
    """However the reader's tables fall on them; only the last one may be shorter."""
    pieces = list(log.pieces(["b", "a"], rows))
    assert [len(piece) for piece in pieces[:-1]] == [rows] * (len(pieces) - 1)
    assert [piece.first for piece in pieces] == list(range(0, 10, rows))
    assert_array_equal(np.concatenate([piece["b"] for piece in pieces]), 10 * np.arange(10))


def test_a_column_is_read_once(log, source):
    """And only it; the length needs no other."""
    assert_array_equal(log["b"], 10 * np.arange(10))
    assert (len(log), log["b"][3]) == (10, 30)
    assert source.asked == [("b",)]


def test_columns_are_loaded_in_one_pass(log, source):
    """Those that are kept are not read again, and those that there are not are left out."""
    log.load(["a", "colour"]).load().load()
    assert source.asked == [("a",), ("b",)]
    assert log.rows()["b"][-1] == 90


def test_unknown_column_says_what_there_is(log):
    """With the file's name."""
    with refused(r"runs/a.log has no 'c'. It has: a, b"):
        log["c"]


def test_a_log_that_grows_stays_as_long_as_its_first_column(log, source):
    """Columns that are read later lie beside it row for row."""
    assert len(log["a"]) == 10
    source.rows = 14
    assert len(log["b"]) == len(log.rows()["a"]) == 10
    assert len(Log(FACTS, ("a", "b"), source)) == 14


def test_added_columns_stand_beside_the_others(log):
    """In pieces too; a column of the same name is replaced, in the new log alone."""
    more = log.add({"a": -np.arange(10), "score/x": np.ones(10)})
    assert more.names == ("a", "b", "score/x")
    assert more["a"][2] == -2
    assert log["a"][2] == 2
    assert [piece["a"].tolist() for piece in more.pieces(["a", "b"], 6)][1] == [-6, -7, -8, -9]


def test_part_has_the_rows_that_are_named(log):
    """In that order, those of added columns too."""
    part = log.add({"c": np.arange(10.0)}).part(np.array([7, 2]))
    assert (part["b"].tolist(), part["c"].tolist(), len(part)) == ([70, 20], [7.0, 2.0], 2)
    assert log.part(log["a"] > 7)["b"].tolist() == [80, 90]
    assert log.part(slice(8, None))["a"].tolist() == [8, 9]


def test_rows_of_uneven_columns_are_refused():
    """In memory and as they are read."""
    uneven = {"a": np.zeros(2), "b": np.zeros(3)}
    with pytest.raises(SchemaError, match="a 2, b 3"):
        in_memory(FACTS, uneven)
    with pytest.raises(SchemaError, match="a 2, b 3"):
        Log(FACTS, ("a", "b"), lambda names: [uneven]).rows()


@pytest.mark.parametrize("kind", [np.float16, np.float32, np.float64])
def test_infinity_is_refused_in_any_precision(kind):
    """1e150 itself is beyond what a float32 holds; a comparison with it says nothing more."""
    assert in_memory(FACTS, {"a": np.ones(2, kind)})["a"].dtype == kind
    with pytest.raises(SchemaError, match="a value of a is inf, which is beyond all returns"):
        in_memory(FACTS, {"a": np.array([1.0, np.inf], kind)})


def test_log_without_rows_has_its_columns():
    """And no episode."""
    log = in_memory(FACTS, {name: np.zeros((0, 2) if name == "x" else 0, int) for name in ("env", "episode", "x")})
    assert (len(log), log["x"].shape) == (0, (0, 2))
    assert episode_rows(log["env"], log["episode"]) == []


def test_episodes_are_told_by_env_and_number():
    """Those that have ended, of envs side by side; `last_rows` stand in the order of the rows."""
    steps = {
        "env": np.array([0, 1, 0, 1, 0, 1], np.int32),
        "episode": np.array([0, 0, 0, 1, 1, 1], np.int32),
        "terminated": np.array([0, 1, 0, 0, 0, 0], bool),
        "truncated": np.array([0, 0, 1, 0, 0, 1], bool),
    }
    log = in_memory(FACTS, steps)
    assert [rows.tolist() for rows in log.episodes] == [[0, 2], [1], [3, 5]]
    assert log.last_rows.tolist() == [1, 2, 5]
    assert [rows.tolist() for rows in episode_rows(log["env"], log["episode"])] == [[0, 2], [4], [1], [3, 5]]
