"""What shows only after a long time: memory that is never given back, and numbers that drift."""

import numpy as np

from harness.robot import Robot
from harness.simulator import Simulator
from harness.testing.memory import require_no_growth, require_nothing_kept, resident
from harness.testing.simulators.simulations import (
    NUM_ENVS,
    PERIOD,
    drive_out_and_back,
    opened,
    ramps,
    same,
    start_at_home,
)
from harness.testing.violations import check, require

STEPS = 10_000
WARM_UP = 0.2
"""The share of the steps in which a plugin may fill its caches."""
EPISODES = 5
"""Out and back, in which nothing may be kept."""


@check("sim-leak")
def nothing_is_kept_of_a_period(simulator: Simulator, robot: Robot) -> None:
    """The memory that Python's objects of a simulation take does not grow from episode to episode."""
    with opened(simulator, robot) as simulation:

        def play_episodes() -> None:
            for _ in range(EPISODES):
                drive_out_and_back(simulation, robot)

        require_nothing_kept(play_episodes, EPISODES * len(ramps(robot, NUM_ENVS)), "control periods")


@check("sim-long-run")
def a_long_simulation_neither_drifts_nor_leaks(simulator: Simulator, robot: Robot) -> None:
    """After 10,000 periods an episode is the same as at the beginning, bit for bit, and the process has not grown."""
    with opened(simulator, robot) as simulation:
        first = drive_out_and_back(simulation, robot)
        targets = ramps(robot, NUM_ENVS)
        warm_up = int(WARM_UP * STEPS)
        before = 0
        for step in range(STEPS):
            if step % len(targets) == 0:
                start_at_home(simulation, robot)
            simulation.drive(targets[step % len(targets)], PERIOD)
            if step == warm_up:
                before = resident()
        require_no_growth(before, STEPS - warm_up, "control periods")
        last = drive_out_and_back(simulation, robot)
    drift = max(np.abs(old.qpos - new.qpos).max() for old, new in zip(first, last, strict=True))
    told = f"after {STEPS:,} periods the same episode goes another way, by up to {drift:.2g} [rad or m] of a joint"
    require(same(first, last), told)
