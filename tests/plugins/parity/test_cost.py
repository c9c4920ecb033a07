"""Costs: the median of control periods, told by the clock; turns; failures."""

from itertools import chain

import pytest
from numpy.testing import assert_array_equal

from harness_plugins.parity import performance
from harness_plugins.parity.motions import smooth_motions
from harness_plugins.parity.performance import Stopwatch, time_in_turns

TURNS, LONGEST_TURN = 8, 50


@pytest.fixture
def motion(robot):
    """One arm's motion, longer than a turn."""
    return smooth_motions(robot, 0, 1, LONGEST_TURN + 20, 0.1).motions[:, 0]


def test_the_median_of_the_drives_is_told(robot, toolbox, motion):
    """By a clock on which every drive takes two seconds but one, which takes a thousand."""
    durations = [1000.0] + [2.0] * (LONGEST_TURN - 1)
    times = chain.from_iterable((0.0, duration) for duration in durations)
    stopwatch = Stopwatch(toolbox.ideal, robot, motion, 0.1, clock=lambda: next(times))
    stopwatch.take_turn()
    assert stopwatch.seconds_per_step == 2.0


def test_simulators_take_turns(robot, toolbox, motion, monkeypatch):
    """None has its turns in a row."""
    turns = []

    class Noting(Stopwatch):
        def take_turn(self):
            turns.append(self)
            super().take_turn()

    monkeypatch.setattr(performance, "Stopwatch", Noting)
    seconds = time_in_turns({"one": toolbox.ideal, "two": toolbox.late}, robot, motion, 0.1)
    assert turns == turns[:2] * TURNS
    assert all(0.0 < second < 1.0 for second in seconds.values())


def test_every_turn_is_the_same(robot, toolbox, motion):
    """It starts where the motion starts, so that the arm never has to jump."""
    stopwatch = Stopwatch(toolbox.ideal, robot, motion, 0.1)
    for _ in range(2):
        stopwatch.take_turn()
        assert_array_equal(stopwatch._simulation.qpos[0], motion[LONGEST_TURN])
