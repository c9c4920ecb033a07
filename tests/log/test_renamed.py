"""A log whose columns get other names, or stay in memory."""

from pathlib import Path

import numpy as np

from harness.log import Failed, Log, LogFacts
from tests.refusals import refused


def _log(passes):
    """Four rows in two tables; every pass over them is noted."""

    def read(names):
        passes.append(names)
        for begin in (0, 2):
            yield {name: np.arange(begin, begin + 2) + len(name) for name in names}

    facts = LogFacts(path=Path("some"), format="of a test", failed=(Failed("reward/a", "no"),))
    return Log(facts, ("time", "reward/a", "reward/a/x"), read, {"reward/b": np.zeros(4)})


def test_columns_have_their_new_names():
    """Added ones too, and what is told of failures; the numbers are those that were there."""
    log = _log([]).renamed({"reward/a": "reward/c", "reward/a/x": "reward/c/x", "reward/b": "reward/d"})
    assert log.names == ("time", "reward/c", "reward/c/x", "reward/d")
    assert log["reward/c/x"].tolist() == [10, 11, 12, 13]
    assert log["reward/d"].tolist() == [0.0] * 4
    assert [it.column for it in log.facts.failed] == ["reward/c"]


def test_two_columns_of_one_name_are_refused():
    """The numbers of one of them would be lost."""
    with refused("'reward/a' cannot be called 'reward/b': some has a column of that name"):
        _log([]).renamed({"reward/a": "reward/b"})


def test_loaded_log_is_read_once():
    """Whatever is asked of it then."""
    passes = []
    log = _log(passes).load()
    assert len(log) == 4
    assert log["reward/a"].tolist() == log.rows(["reward/a"])["reward/a"].tolist() == [8, 9, 10, 11]
    assert passes == [("time", "reward/a", "reward/a/x")]


def test_term_is_no_reward():
    """Though the name of a reward may have a slash."""
    assert _log([]).renamed({"reward/b": "reward/other/b"}).rewards == ("a", "other/b")
