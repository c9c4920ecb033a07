"""Contenders take turns."""

import pytest

from harness_plugins.bench.contests import FEWEST, MOST, Contender, round_of, take_turns
from harness_plugins.bench.stopwatch import Meter


class Work:
    """A clock, and work that takes what is said."""

    def __init__(self) -> None:
        self.now, self.order = 0.0, []

    def clock(self) -> float:
        """Seconds since the beginning."""
        return self.now

    def of(self, name: str, *seconds: float):
        """Work that takes so long, one time after the other, the last one for ever."""
        left = list(seconds)

        def run() -> None:
            self.order.append(name)
            self.now += left.pop(0) if len(left) > 1 else left[0]

        return run


def test_they_take_turns():
    """A slow moment meets both; the first time of each warms up."""
    work = Work()
    contenders = {name: Contender(work.of(name, 1.0), 1) for name in "ab"}
    take_turns(contenders, budget=12.0, clock=work.clock)
    assert work.order == ["a", "b"] * (1 + 6)


def test_what_counts_is_an_environment_step_and_no_warm_up():
    """A turn of 10 steps that takes 2 s is 0.2 s a step; the first one took 50."""
    work = Work()
    found = take_turns({"a": Contender(work.of("a", 50.0, 2.0), 10)}, budget=1.0, clock=work.clock)
    assert found == {"a": [pytest.approx(0.2)] * FEWEST}


@pytest.mark.parametrize(("budget", "turns"), [(0.0, FEWEST), (10.0, 10), (1e9, MOST)])
def test_the_budget_says_how_many_turns(budget: float, turns: int):
    """Never fewer than can be told apart, never without an end."""
    work = Work()
    found = take_turns({"a": Contender(work.of("a", 1.0), 1)}, budget, clock=work.clock)
    assert len(found["a"]) == turns


def test_work_that_is_short_is_repeated_within_a_turn():
    """5 ms of work are done four times, and a step still takes 5 ms."""
    work = Work()
    found = take_turns({"a": Contender(work.of("a", 0.005), 1)}, budget=0.0, clock=work.clock)
    assert len(work.order) == 1 + 4 * FEWEST
    assert found["a"] == [pytest.approx(0.005)] * FEWEST


def test_preparation_does_not_count():
    """It is done before each turn."""
    work = Work()
    found = take_turns(
        {"a": Contender(work.of("a", 1.0), 1, prepare=work.of("prepare", 7.0))}, budget=0.0, clock=work.clock
    )
    assert found["a"] == [pytest.approx(1.0)] * FEWEST
    assert work.order == ["prepare", "a"] * (1 + FEWEST)


def test_a_part_of_the_work_can_be_what_counts():
    """What its meter saw in that turn, per step, and nothing of the rest."""
    work, meter = Work(), Meter()
    meter.clock = work.clock
    inner, outer = meter.timed(work.of("inner", 1.0)), work.of("outer", 3.0)

    def run() -> None:
        inner()
        outer()

    found = take_turns({"simulator": Contender(run, 2, part=meter)}, budget=0.0, clock=work.clock)
    assert found == {"simulator": [pytest.approx(0.5)] * FEWEST}


def test_a_speed_is_the_median_of_what_stood_beside_one_another():
    """The slow turn met both; the ratio of the medians would be 1."""
    told = round_of({"bare": [1.0, 1.0, 8.0], "ours": [2.0, 2.0, 16.0]}, "bare")
    assert told.speeds == {"ours": pytest.approx(0.5)}
    assert told.seconds == {"bare": 1.0, "ours": 2.0}


def test_without_a_reference_there_are_seconds_alone():
    """An algorithm that names no bare library."""
    told = round_of({"ours": [2.0, 3.0, 4.0]}, "")
    assert (told.seconds, told.speeds) == ({"ours": 3.0}, {})
