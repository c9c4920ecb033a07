"""How joints follow their targets: ideal drives closely, others within their limits, parts of a period as a whole."""

import dataclasses
from collections.abc import Callable, Sequence
from functools import wraps
from itertools import pairwise
from typing import Any, cast

import numpy as np

from harness import Float
from harness.errors import UsageError
from harness.robot import Robot, Servo
from harness.robot.energy import energy, read_bodies
from harness.simulator import Simulation, Simulator, State, drives_with_servo

from ..contract import Check, check, require, violations
from .simulations import (
    NUM_ENVS,
    PERIOD,
    copied,
    drive_out_and_back,
    opened,
    ramps,
    same,
    start_at_home,
    turns,
    turns as ways_to_turn,
)

FAR = 0.5
"""How far a joint is told to go at once, as a share of what it can go [rad or m, of a radian or metre at most]."""
ROUNDING = 0.05
"""The rounding of an energy or a way, as a share of it: engines step in time."""
WEAK, STRONG = 0.4, 4.0
"""Limits of drives that are compared, as shares of the robot's."""
HEAVY = 60.0
"""Armature of a drive that is compared, as a multiple of the robot's and of the links' inertia."""

Run = Callable[[Simulator, Robot], None]


def of_ideal_drives(run: Run) -> Run:
    """A check's function that is left out where a simulator is set to drives with limits: these lag behind."""

    @wraps(run)
    def checked(simulator: Simulator, robot: Robot) -> None:
        if not drives_with_servo(simulator):
            run(simulator, robot)

    return checked


def of_servo_drives(run: Callable[[Simulator, Robot, Servo], None]) -> Run:
    """A check's function that gets the simulator set to drives with limits, and the robot's drives.

    It is left out where a simulator has no field `drive`, or a robot no drives.
    """

    @wraps(run)
    def checked(simulator: Simulator, robot: Robot) -> None:
        if hasattr(simulator, "drive") and robot.servo is not None:
            run(dataclasses.replace(cast(Any, simulator), drive="servo"), robot, robot.servo)

    return checked


def servo_check(name: str, checks: Sequence[Check]) -> Check:
    """A check that does others again with ``drive=servo``.

    Args:
        name: Of the check.
        checks: The others.
    """

    def the_contract_holds_with_servo_drives(simulator: Simulator, robot: Robot, servo: Servo) -> None:
        """If there is a field `drive`, all that holds with ideal drives holds with "servo" too, except exact tracking.

        That is every check of resets, ground contact, batches and repetition.
        """
        for violation in violations(checks, simulator, robot):
            raise AssertionError(f"with drive=servo, {violation}") from violation.__cause__

    return check(name)(of_servo_drives(the_contract_holds_with_servo_drives))


@check("sim-servo-limits")
@of_servo_drives
def drives_keep_their_limits(simulator: Simulator, robot: Robot, servo: Servo) -> None:
    """With `drive=servo` the arm gains no more energy than the drives' largest torques give it on its way.

    The energy is that of the links, in motion and in height, and that of the armatures.
    """
    strong = _with(robot, latency=0.0, stiffness=100.0 * servo.stiffness)
    target = strong.home + _far(strong)
    with opened(simulator, strong) as simulation:
        states = [start_at_home(simulation, strong)]
        states += [copied(simulation.drive(target, PERIOD)) for _ in range(2)]
    bodies = read_bodies(robot)
    for before, after in pairwise(states):
        gain = sum(0.5 * (servo.armature * (s.qvel**2)).sum(axis=1) * sign for s, sign in ((after, 1), (before, -1)))
        if bodies is not None:
            told = [energy(robot.chain, bodies, state.qpos, state.qvel) for state in (before, after)]
            gain = gain + told[1] - told[0]
        allowed = (servo.max_torque * np.abs(after.qpos - before.qpos)).sum(axis=1)
        env = int(np.argmax(gain - allowed))
        require(
            (gain <= (1.0 + ROUNDING) * allowed).all(),  # what is no number is not
            f"with drive=servo the arm of env {env} gains {gain[env]:.4g} J in {PERIOD:g} s; "
            f"the largest torques of its drives give it at most {allowed[env]:.4g} J on that way",
        )


@check("sim-servo-latency")
@of_servo_drives
def commands_come_late(simulator: Simulator, robot: Robot, servo: Servo) -> None:
    """With `drive=servo` and a latency of one control period an arm moves as without latency, one period later."""
    prompt, late = (_driven(simulator, _with(robot, latency=latency)) for latency in (0.0, PERIOD))
    way = max(float(np.abs(state.qpos - prompt[0].qpos).max()) for state in prompt)
    for number, (state, later) in enumerate(zip(prompt, late[1:], strict=False)):
        error = float(np.abs(later.qpos - state.qpos).max())
        require(
            error <= ROUNDING * way,
            f"with drive=servo and a latency of {PERIOD:g} s a joint is {error:.3g} rad, after {number + 1} periods, "
            f"from where it is after {number} periods without latency",
        )


@check("sim-servo-strength")
@of_servo_drives
def stronger_drives_follow_better(simulator: Simulator, robot: Robot, servo: Servo) -> None:
    """With `drive=servo` drives with a larger limit are nearer to their targets in a quick motion."""
    weak, strong = (
        _tracking_error(simulator, _with(robot, max_torque=share * servo.max_torque)) for share in (WEAK, STRONG)
    )
    require(
        strong < weak,
        f"with drive=servo the joints are {strong:.3g} rad from their targets, on average, with drives of {STRONG:g} "
        f"times the robot's torque, and {weak:.3g} rad with {WEAK:g} times",
    )


@check("sim-servo-friction")
@of_servo_drives
def friction_holds_the_joints(simulator: Simulator, robot: Robot, servo: Servo) -> None:
    """With `drive=servo` a dry friction above the limit holds every joint, and viscous friction makes it lag."""
    way = np.abs(_far(robot)).max()
    held = _moved(simulator, _with(robot, dry_friction=3.0 * servo.max_torque))
    require(
        held.max() <= ROUNDING * way, f"with drive=servo dry friction above the limit lets a joint go {held.max():.3g}"
    )
    free, slow = (
        _moved(simulator, _with(robot, viscous_friction=friction, dry_friction=0.0 * servo.dry_friction))
        for friction in (0.0 * servo.viscous_friction, servo.max_torque / robot.max_speed)
    )
    require((slow < free).all(), f"with drive=servo viscous friction lets joints go {slow}, none lets them go {free}")


@check("sim-servo-armature")
@of_servo_drives
def armature_makes_the_joints_slow(simulator: Simulator, robot: Robot, servo: Servo) -> None:
    """With `drive=servo` joints with a large armature gain less speed than those of the robot."""
    own = _moved(simulator, robot)
    heavy = _moved(simulator, _with(robot, armature=HEAVY * (servo.armature + _inertia(robot))))
    require(
        (heavy < 0.5 * own).all(), f"with drive=servo joints of large armature go {heavy}, those of the robot {own}"
    )


@check("sim-servo-forgets")
@of_servo_drives
def reset_forgets_commands(simulator: Simulator, robot: Robot, servo: Servo) -> None:
    """With `drive=servo` a reset forgets what the drives followed, and commands that they did not follow yet."""
    late = _with(robot, latency=2.0 * PERIOD)
    with opened(simulator, late) as simulation:
        fresh = drive_out_and_back(simulation, late)
        simulation.drive(late.home + _far(late), PERIOD)
        again = drive_out_and_back(simulation, late)
    require(same(fresh, again), "with drive=servo an arm that was reset moves by commands of before the reset")


SERVO_CHECKS = (
    drives_keep_their_limits,
    commands_come_late,
    stronger_drives_follow_better,
    friction_holds_the_joints,
    armature_makes_the_joints_slow,
    reset_forgets_commands,
)


def _with(robot: Robot, **changes: Any) -> Robot:
    """The same arm with other drives."""
    return dataclasses.replace(robot, servo=dataclasses.replace(cast(Any, robot.servo), **changes))


def _far(robot: Robot) -> Float:
    """A way in both directions from home, (NUM_ENVS, dof), within the joints' ranges, of which it takes a share."""
    ways = ways_to_turn(robot, NUM_ENVS)
    room = np.where(ways > 0.0, robot.upper - robot.home, robot.home - robot.lower)
    far: Float = FAR * ways * np.minimum(room, 1.0)
    return far


def _driven(simulator: Simulator, robot: Robot) -> list[State]:
    with opened(simulator, robot) as simulation:
        return drive_out_and_back(simulation, robot)


def _tracking_error(simulator: Simulator, robot: Robot) -> float:
    """The mean error of all joints in all periods of `ramps`, [rad] or [m]."""
    states, targets = _driven(simulator, robot)[1:], ramps(robot, NUM_ENVS)
    return float(np.mean([np.abs(state.qpos - target) for state, target in zip(states, targets, strict=True)]))


def _moved(simulator: Simulator, robot: Robot) -> Float:
    """How far each joint gets in two periods that tell it to go far at once, (dof,), [rad] or [m], mean over envs."""
    with opened(simulator, robot) as simulation:
        home = start_at_home(simulation, robot).qpos
        for _ in range(2):
            state = copied(simulation.drive(home + _far(robot), PERIOD))
    moved: Float = np.abs(state.qpos - home).mean(axis=0)
    return moved


def _inertia(robot: Robot) -> Float:
    """Diagonal of the links' joint-space inertia at home, (dof,), [kg m^2] or [kg]; 0 without masses."""
    bodies = read_bodies(robot)
    if bodies is None:
        return np.zeros(robot.dof)
    home, unit = np.tile(robot.home, (robot.dof, 1)), np.eye(robot.dof)
    inertia: Float = 2.0 * (energy(robot.chain, bodies, home, unit) - energy(robot.chain, bodies, home, 0.0 * unit))
    return inertia


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
