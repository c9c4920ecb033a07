"""What a simulator must satisfy that can simulate drives with limits: one whose field `drive` takes "servo"."""

import dataclasses
from collections.abc import Callable, Sequence
from functools import wraps
from itertools import pairwise
from typing import Any, cast

import numpy as np

from harness.arrays import Float
from harness.robot import Robot
from harness.robot.energy import energy, read_bodies
from harness.robot.servo import Servo
from harness.simulator import Simulator, State, drives_with_servo
from harness.testing.simulators.simulations import (
    NUM_ENVS,
    PERIOD,
    copied,
    drive_out_and_back,
    opened,
    ramps,
    same,
    start_at_home,
)
from harness.testing.simulators.simulations import turns as ways_to_turn
from harness.testing.violations import Check, check, require, violations

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


SERVO_CHECKS: tuple[Check, ...] = (
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
