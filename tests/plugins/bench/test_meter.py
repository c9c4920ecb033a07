"""Meters of calls, and the times of a cell that they add up to."""

import json
from dataclasses import asdict

import numpy as np
import pytest

from harness_plugins.bench.stopwatch import (
    PARTS,
    TRAINING,
    CellTimes,
    Meter,
    TimedMethods,
    TimedReward,
    seconds_per_call,
)


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
    assert CellTimes(**json.loads(json.dumps(asdict(make_times())))) == make_times()


def test_training_is_made_of_parts():
    """Of some, in their order, not of all."""
    assert [part for part in PARTS if part in TRAINING] == list(TRAINING)
    assert len(TRAINING) < len(PARTS)


class Clock:
    """Shows what it is told to."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        """As it stands."""
        return self.now


class Engine:
    """Takes two seconds for a drive."""

    dof = 6

    def __init__(self, clock: Clock) -> None:
        self._clock = clock

    def drive(self, qpos, duration):
        """Move."""
        self._clock.now += 2.0
        return qpos, duration

    def close(self):
        """Stop."""
        self._clock.now += 5.0


class Pay:
    """A reward with slots: nothing can be written into it."""

    __slots__ = ()

    def initial_carry(self, begin_distance):
        """Nothing much."""
        return begin_distance

    def __call__(self, carry, sample):
        """Counts up."""
        return carry + 1.0, -sample


def test_seconds_and_calls_are_summed_up():
    """Two drives take four seconds."""
    clock = Clock()
    meter = Meter(clock)
    drive = meter.timed(Engine(clock).drive)
    assert drive("here", duration=0.1) == ("here", 0.1)
    drive("there", 0.1)
    assert (meter.seconds, meter.calls) == (4.0, 2)


def test_only_named_methods_are_timed():
    """The others, and what is no method, are the object's own; a method that it lacks is still lacking."""
    clock = Clock()
    meter = Meter(clock)
    engine = TimedMethods(Engine(clock), ("drive", "place"), meter)
    engine.drive("here", 0.1)
    engine.close()
    assert (meter.seconds, meter.calls, engine.dof) == (2.0, 1, 6)
    assert not hasattr(engine, "place")


def test_reward_pays_the_same_when_it_is_timed():
    """Both its calls are counted, its values are its own."""
    meter = Meter()
    timed = TimedReward(Pay(), meter)
    distance = np.array([0.5])
    carry, value = timed(timed.initial_carry(distance), distance)
    np.testing.assert_array_equal([carry, value], [[1.5], [-0.5]])
    assert meter.calls == 2
    assert meter.seconds > 0.0


def test_what_is_raised_passes():
    """A simulation that diverges still does."""
    meter = Meter()
    with pytest.raises(ZeroDivisionError):
        meter.timed(lambda: 1 / 0)()


def test_timing_a_call_takes_microseconds_at_most():
    """More than nothing, and less than ten microseconds even on a busy machine."""
    assert 0.0 < seconds_per_call(calls=1_000) < 1e-5
