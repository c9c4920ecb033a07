"""How episodes ended."""

from dataclasses import replace

import pytest

from harness.report.page.comparison import outcome_bars


def test_shares_make_one(one):
    """Three of four reach the target, the fourth runs out of time; random actions hit the ground."""
    bars = outcome_bars(one)
    assert [bar.who for bar in bars] == ["Baseline", "Proposed", "Random"]
    assert [[part.kind for part in bar.parts] for bar in bars] == [["reached", "time-out"]] * 2 + [["ground"]]
    assert [sum(part.share for part in bar.parts) for bar in bars] == pytest.approx([1.0] * 3)
    assert bars[0].told == "reached 75.0%, ground 0.0%, time-out 25.0%"


def test_obstacles_are_told_apart_from_the_ground(one):
    """What neither reached the target nor ran out of time nor touched an obstacle ended on the ground."""
    success = one.measured.changes_of(one.manner)[0]
    changes = [
        replace(success, measure=success.measure._replace(name=name), baseline=share)
        for name, share in (("success_rate", 0.5), ("timeouts", 0.125), ("obstacle_hits", 0.25))
    ]
    bar, *_ = outcome_bars(replace(one, measured=replace(one.measured, changes=tuple(changes))))
    assert {part.kind: part.share for part in bar.parts} == {
        "reached": 0.5,
        "ground": 0.125,
        "time-out": 0.125,
        "obstacle": 0.25,
    }
