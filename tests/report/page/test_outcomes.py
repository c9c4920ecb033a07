"""How episodes ended."""

import pytest

from harness.report.page.comparison import _bar, outcome_bars


def test_shares_make_one(build):
    """Three of four reach the target, the fourth runs out of time; random actions hit the ground."""
    (combination,) = build().combinations
    bars = outcome_bars(combination)
    assert [bar.who for bar in bars] == ["Baseline", "Proposed", "Random"]
    assert [[part.kind for part in bar.parts] for bar in bars] == [["reached", "time-out"]] * 2 + [["ground"]]
    assert [sum(part.share for part in bar.parts) for bar in bars] == pytest.approx([1.0] * 3)
    assert bars[0].told == "reached 75.0%, ground 0.0%, time-out 25.0%"


def test_obstacles_are_told_apart_from_the_ground():
    """What neither reached the target nor ran out of time nor touched an obstacle ended on the ground."""
    bar = _bar("Baseline", "dense", 0.5, 0.125, 0.25)
    assert {part.kind: part.share for part in bar.parts} == {
        "reached": 0.5,
        "ground": 0.125,
        "time-out": 0.125,
        "obstacle": 0.25,
    }
