"""What one environment step of one arm costs, measured taking turns."""

import time
from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from harness.arrays import Float
from harness.robot import Robot
from harness.simulator import Simulator

from .failure import Failure, attempt, part

TURNS = 8
LONGEST_TURN = 50
"""Control periods."""


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
