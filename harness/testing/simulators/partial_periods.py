"""Whether the parts of a control period add up to the whole: what the action modes that draw lines rely on."""

import numpy as np

from harness.arrays import Float
from harness.errors import UsageError
from harness.robot import Robot
from harness.simulator import Simulation, Simulator, State
from harness.testing.simulators.servos import of_ideal_drives
from harness.testing.simulators.simulations import NUM_ENVS, PERIOD, copied, opened, start_at_home, turns
from harness.testing.violations import check, require

PARTS = (2, 4)
"""Into how many a period is divided."""
SPEED = 0.3
"""The speed of the steady motion, as a share of the largest speed."""
WARM_UP = 3
"""Whole periods before the one that is divided."""
TOLERANCE = 0.05
"""The tolerance of the way of a part, and of a speed, as a share of them."""


@check("sim-partial-durations")
@of_ideal_drives
def parts_of_a_period_add_up(simulator: Simulator, robot: Robot) -> None:
    """Parts of a control period, driven one after the other, lead where the whole period leads, at the same speed.

    A simulator may refuse to divide a period into so many parts, with UsageError.
    """
    speed = SPEED * robot.max_speed * turns(robot, NUM_ENVS)
    for parts in PARTS:
        with opened(simulator, robot) as simulation:
            before, whole = _in_steady_motion(simulation, robot, speed)
            target, way = whole.qpos, whole.qpos - before.qpos
            duration = PERIOD / parts
            last = whole
            for part in range(1, parts + 1):
                try:
                    state = copied(simulation.drive(target + part * duration * speed, duration))
                except UsageError:
                    break
                _require_way(last, state, way / parts, duration)
                _require_speed(state, whole, duration)
                last = state
            else:
                # A part that lasted too long or too short shows in the whole period after it.
                state = copied(simulation.drive(target + 2.0 * PERIOD * speed, PERIOD))
                _require_way(last, state, way, PERIOD)


def _in_steady_motion(simulation: Simulation, robot: Robot, speed: Float) -> tuple[State, State]:
    """Drive every joint at constant speed for some whole periods; returns the last two states."""
    states = [start_at_home(simulation, robot)]
    for period in range(1, WARM_UP + 1):
        states.append(copied(simulation.drive(states[0].qpos + period * PERIOD * speed, PERIOD)))
    return states[-2], states[-1]


def _require_way(before: State, after: State, way: Float, duration: float) -> None:
    """From one state to the next each joint went as far as it goes in such a part of a whole period."""
    moved = after.qpos - before.qpos
    env, joint = _worst(moved - way)
    require(
        np.abs(moved - way).max() <= TOLERANCE * np.abs(way).max(),  # what is no number is not
        f"in a steady motion drive(qpos, {duration:g}) moved joint {joint + 1} by {moved[env, joint]:.3g}, and "
        f"{way[env, joint]:.3g} is that part of what drive(qpos, {PERIOD:g}) moves it by: "
        "parts of a period have to add up",
    )


def _require_speed(state: State, whole: State, duration: float) -> None:
    """The same motion has the same speed."""
    env, joint = _worst(state.qvel - whole.qvel)
    require(
        np.abs(state.qvel - whole.qvel).max() <= TOLERANCE * np.abs(whole.qvel).max(),
        f"in a steady motion drive(qpos, {duration:g}) says that joint {joint + 1} has the speed "
        f"{state.qvel[env, joint]:.3g}, and drive(qpos, {PERIOD:g}) says {whole.qvel[env, joint]:.3g}: "
        "a part of a period has the speed of the whole",
    )


def _worst(errors: Float) -> tuple[int, int]:
    """Env and joint of the largest error; of what is no number, if there is any."""
    env, joint = np.unravel_index(np.argmax(np.nan_to_num(np.abs(errors), nan=np.inf)), errors.shape)
    return int(env), int(joint)
