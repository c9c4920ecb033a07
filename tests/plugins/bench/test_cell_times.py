"""The times of one cell."""

import json

import pytest

from harness_plugins.bench.stopwatch import PARTS, TRAINING, CellTimes


def test_whole_is_the_sum_of_the_parts(make_times):
    """No part is missing, none counts twice."""
    assert make_times().whole == pytest.approx(10.0)


def test_the_end_of_the_process_is_saving(make_times):
    """What comes after the times were told belongs to the last part, and to no other."""
    later = make_times().ended_after(2.0)
    assert later.seconds["saving"] == pytest.approx(2.4)
    assert later.whole == pytest.approx(12.0)


def test_json_gives_the_same_times_back(make_times):
    """Through text, as one process tells another."""
    assert CellTimes.from_json(json.loads(json.dumps(make_times().to_json()))) == make_times()


def test_training_is_made_of_parts():
    """Of some, in their order, not of all."""
    assert [part for part in PARTS if part in TRAINING] == list(TRAINING)
    assert len(TRAINING) < len(PARTS)
