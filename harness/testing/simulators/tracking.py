"""Ideal drives: joints go where they are driven, at the speed that they report."""

import numpy as np

from harness.robot import Robot
from harness.simulator import Simulator
from harness.testing.simulators.servos import of_ideal_drives
from harness.testing.simulators.simulations import (
    NUM_ENVS,
    PERIOD,
    drive_out_and_back,
    opened,
    ramps,
    start_at_home,
    turns,
)
from harness.testing.violations import check, require

MAX_TRACKING_ERROR = np.radians(0.5)
"""The largest error of a joint that turns."""
MAX_SLIDING_ERROR = 5e-3
"""[m]"""
MAX_SPEED_ERROR = 0.05
"""The largest error of a joint in steady motion, as a fraction of its speed."""
SMALL_MOVE = np.radians(0.3)


@check("sim-tracking")
@of_ideal_drives
def drive_tracks_a_joint_ramp(simulator: Simulator, robot: Robot) -> None:
    """At the end of each control period every joint is within 0.5 degrees of its target, 5 mm where it slides."""
    with opened(simulator, robot) as simulation:
        states = drive_out_and_back(simulation, robot)[1:]
        for state, target in zip(states, ramps(robot, NUM_ENVS), strict=True):
            errors, slides = np.abs(state.qpos - target), robot.chain.slides
            turned, slid = (errors[:, kind].max(initial=0.0) for kind in (~slides, slides))
            # Not a number is no small error.
            require(turned < MAX_TRACKING_ERROR, f"a joint is {np.degrees(turned):.2g} degrees from its target")
            require(slid < MAX_SLIDING_ERROR, f"a joint is {slid:.2g} m from its target")


@check("sim-velocity")
@of_ideal_drives
def qvel_is_the_speed_of_a_steady_motion(simulator: Simulator, robot: Robot) -> None:
    """Joint velocities are in rad/s or m/s, signed: a joint that is driven at constant speed reports that speed."""
    speed = 0.1 * robot.max_speed * turns(robot, NUM_ENVS)
    with opened(simulator, robot) as simulation:
        target = start_at_home(simulation, robot).qpos
        for _ in range(5):
            target = target + speed * PERIOD
            state = simulation.drive(target, PERIOD)
        error = np.abs(state.qvel - speed) / np.abs(speed)
        require(error.max() < MAX_SPEED_ERROR, f"joints driven at {speed} report {state.qvel}")


@check("sim-small-moves")
@of_ideal_drives
def small_moves_move_every_joint(simulator: Simulator, robot: Robot) -> None:
    """A move too small for the tracking check is done all the same: no joint stands still or turns the wrong way."""
    move = SMALL_MOVE * robot.per_radian * turns(robot, NUM_ENVS)
    with opened(simulator, robot) as simulation:
        start = start_at_home(simulation, robot).qpos
        moved = simulation.drive(start + move, PERIOD).qpos - start
        require((moved * move > 0.0).all(), f"driven by {move} rad or m, the joints moved by {moved}")
