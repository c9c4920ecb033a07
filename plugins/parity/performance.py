"""What one simulator makes of its orders, and what a step of it costs. One that fails costs itself alone."""

import time
from collections.abc import Callable, Mapping
from contextlib import closing
from functools import partial
from typing import NamedTuple, TypeVar

import numpy as np

from harness import Float
from harness.env.solid_probes import Probe, find_missing
from harness.errors import HarnessError, one_line
from harness.robot import Robot
from harness.simulator import Simulator

from .classes import CONTACT, SMOOTH
from .orders import Orders, Setting
from .track import Track, follow, place_at

Result = TypeVar("Result")
TURNS = 8
LONGEST_TURN = 50
"""Control periods."""


class Failure(NamedTuple):
    """Why there is no result; one line."""

    reason: str


def attempt(work: Callable[[], Result]) -> Result | Failure:
    """The result of `work`, or why there is none, whatever a stranger's engine raises."""
    try:
        return work()
    except Exception as error:
        told = " ".join(str(error).split()) if isinstance(error, HarnessError) else ""
        return Failure(told or one_line(error))


def part(outcomes: Mapping[str, Result | Failure]) -> tuple[dict[str, Result], dict[str, Failure]]:
    """The results and the failures, in their order."""
    results: dict[str, Result] = {}
    failures: dict[str, Failure] = {}
    for name, outcome in outcomes.items():
        if isinstance(outcome, Failure):
            failures[name] = outcome
        else:
            results[name] = outcome
    return results, failures


class Performance(NamedTuple):
    """A track of each order."""

    placed: Track
    driven: Track
    dived: Track | None
    others: dict[str, Track]
    """The tracks of the other classes of motions."""
    missing: tuple[Probe, ...]
    """The solids that it lacks."""

    @property
    def classes(self) -> dict[str, Track]:
        """The tracks of every class of motions."""
        dived = {} if self.dived is None else {CONTACT: self.dived}
        return {SMOOTH: self.driven, **dived, **self.others}


def perform(simulator: Simulator, setting: Setting, orders: Orders) -> Performance:
    """Open the simulator and do all that is ordered.

    Raises:
        SimulationDiverged: A number is not finite.
    """
    with closing(simulator.open(setting.robot, setting.episodes, setting.period)) as simulation:
        placed = place_at(simulation, orders.poses)
        driven = follow(simulation, orders.motion, setting.period)
        dived = None if orders.dives is None else follow(simulation, orders.dives, setting.period)
        others = {name: follow(simulation, motion, setting.period) for name, motion in orders.others.items()}
        missing = find_missing(simulation, orders.probes, setting.episodes)
    return Performance(placed, driven, dived, others, missing)


class Stopwatch:
    """One arm in one simulator, driven a turn at a time, each control period timed.

    Turns, since a busy machine slows whoever is at it: all simulators are to meet the same weather.
    """

    def __init__(
        self,
        simulator: Simulator,
        robot: Robot,
        motion: Float,
        period: float,
        clock: Callable[[], float] = time.perf_counter,
    ) -> None:
        """Start.

        Args:
            simulator: Whose steps are timed.
            robot: The arm.
            motion: Joint targets, (rows, dof), [rad].
            period: Control period, [s].
            clock: Tells the time, [s].
        """
        self._motion, self._period, self._clock = motion[: LONGEST_TURN + 1, None], period, clock
        self._durations: list[float] = []
        self._simulation = simulator.open(robot, 1, period)

    def take_turn(self) -> None:
        """Reset the arm and drive it along the beginning of the motion."""
        simulation, clock = self._simulation, self._clock
        simulation.reset(self._motion[0], np.ones(1, bool))
        for target in self._motion[1:]:
            begin = clock()
            simulation.drive(target, self._period)
            self._durations.append(clock() - begin)

    @property
    def seconds_per_step(self) -> float:
        """Median over all control periods of all turns taken, [s]."""
        return float(np.median(self._durations))

    def close(self) -> None:
        """Release the engine."""
        self._simulation.close()


def time_in_turns(
    simulators: Mapping[str, Simulator], robot: Robot, motion: Float, period: float
) -> dict[str, float | Failure]:
    """What a step of each simulator costs, [s], or why that is not known.

    Args:
        simulators: By name.
        robot: The arm.
        motion: Joint targets, (rows, dof), [rad].
        period: Control period, [s].
    """
    opened, failed = part(
        {name: attempt(partial(Stopwatch, it, robot, motion, period)) for name, it in simulators.items()}
    )
    running = dict(opened)
    for _ in range(TURNS):
        _, stopped = part({name: attempt(stopwatch.take_turn) for name, stopwatch in running.items()})
        failed |= stopped
        running = {name: stopwatch for name, stopwatch in running.items() if name not in stopped}
    _, unclosed = part({name: attempt(stopwatch.close) for name, stopwatch in opened.items()})
    failed = unclosed | failed
    return {name: failed[name] if name in failed else opened[name].seconds_per_step for name in simulators}
