"""What a simulator must satisfy. Each check takes the simulator and a robot."""

from functools import partial

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.env.logged_simulation import LoggedSimulation
from harness.errors import UsageError
from harness.progress import TrainingState
from harness.robot import Robot
from harness.robot.load import load_robot
from harness.simulator import Simulation, Simulator, State
from harness.testing.simulators.batches import (
    a_simulation_has_its_methods,
    every_env_does_what_it_was_told,
    ground_contact_is_the_envs_own,
    states_are_not_the_callers_arrays,
)
from harness.testing.simulators.partial_periods import parts_of_a_period_add_up
from harness.testing.simulators.servos import SERVO_CHECKS, of_ideal_drives, servo_check
from harness.testing.simulators.simulations import (
    NUM_ENVS,
    PERIOD,
    copied,
    dive_into_the_ground,
    drive_out_and_back,
    opened,
    part,
    poses_near_home,
    ramps,
    same,
    start_at_home,
    turns,
    way_into_the_ground,
)
from harness.testing.violations import Check, check, raise_first, require, settings_are_frozen, settings_survive_json

MAX_TRACKING_ERROR = np.radians(0.5)
"""Of a joint that turns."""
MAX_SLIDING_ERROR = 5e-3
"""[m]"""
MAX_PLACEMENT_ERROR = 1e-6
"""[m] and [rad]."""
MAX_SPEED_ERROR = 0.05
"""Of a joint in steady motion, as a fraction of its speed."""
SMALL_MOVE = np.radians(0.3)
RESETS = {1: (0,), 3: (1,), 4: (0,)}
"""Which envs are reset again, after so many periods, while the others go on."""
BACK = 5
"""Periods that they move on for, later."""
TARGET = np.array([0.6, 0.2, 0.5])
"""Of the frames, [m]."""


def check_simulator(simulator: Simulator, robot: Robot | None = None) -> None:
    """Run all `SIMULATOR_CHECKS`.

    Args:
        simulator: To be checked.
        robot: To be simulated; fd100 if None.

    Raises:
        ContractViolation: At the first check that fails.
    """
    raise_first(SIMULATOR_CHECKS, simulator, robot or load_robot("fd100"))


@check("sim-shapes")
def states_have_the_declared_shapes(simulator: Simulator, robot: Robot) -> None:
    """Joint arrays are (num_envs, dof), positions (num_envs, 3), flags (num_envs,), also for one env."""
    for num_envs in (1, NUM_ENVS):
        shapes = ((num_envs, robot.dof), (num_envs, robot.dof), (num_envs, 3), (num_envs,))
        with opened(simulator, robot, num_envs) as simulation:
            for state in drive_out_and_back(simulation, robot, num_envs):
                for name, array, shape in zip(State._fields, state, shapes, strict=True):
                    require(array.shape == shape, f"{name} of {num_envs} envs has shape {array.shape}, not {shape}")


@check("sim-dtypes")
def states_are_float64_and_bool(simulator: Simulator, robot: Robot) -> None:
    """Numbers are float64 and ground contact is bool, whatever the engine computes with."""
    with opened(simulator, robot) as simulation:
        for state in drive_out_and_back(simulation, robot):
            for name, array, dtype in zip(State._fields, state, ("float64",) * 3 + ("bool",), strict=True):
                require(array.dtype == dtype, f"{name} is {array.dtype}, not {dtype}")


@check("sim-finite")
def states_are_finite(simulator: Simulator, robot: Robot) -> None:
    """No number is NaN or infinite, neither in free motion nor against the ground."""
    with opened(simulator, robot) as simulation:
        for state in [*drive_out_and_back(simulation, robot), *dive_into_the_ground(simulation, robot)]:
            for name, array in zip(State._fields, state, strict=True):
                require(np.isfinite(array).all(), "{} is {}", name, array)


@check("sim-reset")
def reset_puts_the_arm_there_at_rest(simulator: Simulator, robot: Robot) -> None:
    """After `reset` the joints of the masked envs rest where the call put them, also after a motion."""
    with opened(simulator, robot) as simulation:
        drive_out_and_back(simulation, robot)
        qpos = poses_near_home(robot, NUM_ENVS)
        _require_there_at_rest(simulation.reset(qpos, np.ones(NUM_ENVS, bool)), qpos)


@check("sim-place")
def place_puts_the_arm_there_at_rest(simulator: Simulator, robot: Robot) -> None:
    """After `place` the joints of all envs rest where the call put them, also after a motion."""
    with opened(simulator, robot) as simulation:
        drive_out_and_back(simulation, robot)
        qpos = poses_near_home(robot, NUM_ENVS)
        _require_there_at_rest(simulation.place(qpos), qpos)


@check("sim-reset-mask")
def reset_leaves_the_other_envs_alone(simulator: Simulator, robot: Robot) -> None:
    """`reset` changes nothing in the envs outside its mask."""
    mask = np.arange(NUM_ENVS) == 0
    with opened(simulator, robot) as simulation:
        before = drive_out_and_back(simulation, robot)[-1]
        after = simulation.reset(poses_near_home(robot, NUM_ENVS), mask)
        require(same([part(before, ~mask)], [part(after, ~mask)]), "the envs outside the mask changed")


@check("sim-end-effector")
def end_effector_is_that_of_the_robot(simulator: Simulator, robot: Robot) -> None:
    """The end effector is where `robot.end_effector` puts it for the joint positions of the same state."""
    with opened(simulator, robot) as simulation:
        driven = drive_out_and_back(simulation, robot)
        for state in [*driven, copied(simulation.place(poses_near_home(robot, NUM_ENVS)))]:
            error = np.linalg.norm(state.end_effector - robot.end_effector(state.qpos), axis=-1).max()
            require(error < MAX_PLACEMENT_ERROR, f"the end effector is {error:.2g} m from the robot's kinematics")


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
    move = SMALL_MOVE * turns(robot, NUM_ENVS)
    with opened(simulator, robot) as simulation:
        start = start_at_home(simulation, robot).qpos
        moved = simulation.drive(start + move, PERIOD).qpos - start
        require((moved * move > 0.0).all(), f"driven by {move} rad, the joints moved by {moved}")


@check("sim-ground-contact")
def ground_contact_is_seen(simulator: Simulator, robot: Robot) -> None:
    """An arm that is driven into the ground touches it."""
    with opened(simulator, robot) as simulation:
        contacts = [state.ground_contact for state in dive_into_the_ground(simulation, robot)]
        require(np.any(contacts, axis=0).all(), "the arm was driven into the ground and touched nothing")


@check("sim-no-false-contact")
def no_ground_contact_in_the_air(simulator: Simulator, robot: Robot) -> None:
    """An arm at home, or moving about it, does not touch the ground."""
    with opened(simulator, robot) as simulation:
        for state in drive_out_and_back(simulation, robot):
            require(not state.ground_contact.any(), "the arm touches the ground in the air")


@check("sim-read")
def read_returns_the_state_of_the_last_call(simulator: Simulator, robot: Robot) -> None:
    """`read` returns, each time, the state that the last `reset` or `drive` returned."""
    with opened(simulator, robot) as simulation:
        for call in (start_at_home, lambda *given: drive_out_and_back(*given)[-1]):
            state = call(simulation, robot)
            for _ in range(2):
                require(same([simulation.read()], [state]), "read() tells another state")


@check("sim-arguments")
def arguments_are_copied(simulator: Simulator, robot: Robot) -> None:
    """The caller's arrays are neither changed nor kept: what the caller does to them later changes nothing."""
    runs = [_called_with_changing_arrays(simulator, robot, change) for change in (0.0, 1.0)]
    require(same(*runs), "an array that the caller changed after the call is part of the state")


@check("sim-determinism")
def same_calls_give_same_states(simulator: Simulator, robot: Robot) -> None:
    """Two simulations that get the same calls return the same states, bit for bit."""
    runs = []
    for _ in range(2):
        with opened(simulator, robot) as simulation:
            driven = drive_out_and_back(simulation, robot)
            placed = copied(simulation.place(poses_near_home(robot, NUM_ENVS)))
            runs.append([*driven, placed, *dive_into_the_ground(simulation, robot)])
    require(same(*runs), "the same calls gave other states the second time")


@check("sim-reset-forgets")
def reset_forgets_what_was_before(simulator: Simulator, robot: Robot) -> None:
    """What an arm does after a reset does not depend, not by a bit, on what was before, not even on ground contact."""
    with opened(simulator, robot) as simulation:
        fresh = drive_out_and_back(simulation, robot)
        dive_into_the_ground(simulation, robot)
        again = drive_out_and_back(simulation, robot)
    require(same(fresh, again), "after a reset the arm moves differently than when it was new")


@check("sim-resume")
def the_same_way_leads_to_the_same_place(simulator: Simulator, robot: Robot) -> None:
    """An arm that gets all calls since its last reset again stands where it stood, bit for bit, and goes on alike.

    Whatever came before that reset, and whenever other envs were reset; touching the ground, too. Trainings that were
    killed go on from checkpoints that hold no more of the physics.
    """
    stood, went_on = _goes_on(simulator, robot, None)
    if not same(went_on, _goes_on(simulator, robot, None)[1]):
        return  # it does not even do the same in the same run: another check says so
    require(same(went_on, _goes_on(simulator, robot, stood)[1]), "an arm that stands where it stood moves differently")


@check("sim-batch-as-alone")
def an_env_in_a_batch_is_as_one_alone(simulator: Simulator, robot: Robot) -> None:
    """Each env of a batch has the same states, bit for bit, as an env alone that gets the same calls."""
    batch, alone = _driven_alike(simulator, robot, NUM_ENVS), _driven_alike(simulator, robot, 1)
    for env in range(NUM_ENVS):
        one = [part(state, np.array([env])) for state in batch]
        require(same(one, alone), f"env {env} of {NUM_ENVS} moves differently than one env alone")


@check("sim-env-isolation")
def envs_do_not_touch_one_another(simulator: Simulator, robot: Robot) -> None:
    """What an env does is the same, bit for bit, whatever commands the other envs get."""
    runs = [_driven_beside(simulator, robot, share) for share in (1.0, 0.5)]
    require(same(*runs), "env 1 moves differently when the others do")


@check("sim-rest")
def resting_arms_change_nothing(simulator: Simulator, robot: Robot) -> None:
    """If the simulation has `rest`, the other arms move as they do without it, and a reset wakes an arm."""
    with opened(simulator, robot) as simulation:
        if getattr(simulation, "rest", None) is None:
            return
    alone, beside = (_driven_with_rest(simulator, robot, rests) for rests in (False, True))
    require(same(alone[0], beside[0]), "an arm moves in another way while others rest")
    require(same(alone[1], beside[1]), "an arm that has rested and is reset does not move as one that has not")


@check("sim-render")
def render_gives_a_frame_or_says_why_not(simulator: Simulator, robot: Robot) -> None:
    """`render` gives RGB frames, each of the size asked for, or raises UsageError; the state stays as it was."""
    with opened(simulator, robot) as simulation:
        before = drive_out_and_back(simulation, robot)[-1]
        for width, height in ((64, 48), (80, 60)):
            frame = _frame(simulation, TARGET, width, height)
            if frame is None:
                return
            size = f"a frame of {width} x {height}"
            require(frame.shape == (height, width, 3), f"{size} has shape {frame.shape}, not {(height, width, 3)}")
            require(frame.dtype == np.uint8, f"{size} is {frame.dtype}, not uint8")
        require(same([simulation.read()], [before]), "rendering changed the state")


@check("sim-render-target")
def frames_show_the_target(simulator: Simulator, robot: Robot) -> None:
    """If `render` gives frames, a target at another place gives another frame."""
    with opened(simulator, robot) as simulation:
        start_at_home(simulation, robot)
        first, second = (_frame(simulation, TARGET + offset, 320, 240) for offset in (0.0, 0.2))
        if first is not None and second is not None:
            require(not np.array_equal(first, second), "the frame is the same wherever the target is")


@check("sim-close")
def close_can_be_called_twice(simulator: Simulator, robot: Robot) -> None:
    """`close` releases the engine, and a second call does nothing."""
    simulation = simulator.open(robot, NUM_ENVS, PERIOD)
    simulation.close()
    simulation.close()


SERVO_CONTRACT = servo_check(
    "sim-servo",
    (
        states_are_finite,
        reset_puts_the_arm_there_at_rest,
        place_puts_the_arm_there_at_rest,
        reset_leaves_the_other_envs_alone,
        end_effector_is_that_of_the_robot,
        ground_contact_is_seen,
        no_ground_contact_in_the_air,
        ground_contact_is_the_envs_own,
        arguments_are_copied,
        every_env_does_what_it_was_told,
        same_calls_give_same_states,
        reset_forgets_what_was_before,
        the_same_way_leads_to_the_same_place,
        an_env_in_a_batch_is_as_one_alone,
        envs_do_not_touch_one_another,
        resting_arms_change_nothing,
    ),
)

SIMULATOR_CHECKS: tuple[Check, ...] = (
    settings_are_frozen,
    settings_survive_json,
    a_simulation_has_its_methods,
    states_have_the_declared_shapes,
    states_are_float64_and_bool,
    states_are_finite,
    reset_puts_the_arm_there_at_rest,
    place_puts_the_arm_there_at_rest,
    reset_leaves_the_other_envs_alone,
    end_effector_is_that_of_the_robot,
    drive_tracks_a_joint_ramp,
    qvel_is_the_speed_of_a_steady_motion,
    parts_of_a_period_add_up,
    small_moves_move_every_joint,
    ground_contact_is_seen,
    no_ground_contact_in_the_air,
    ground_contact_is_the_envs_own,
    read_returns_the_state_of_the_last_call,
    arguments_are_copied,
    states_are_not_the_callers_arrays,
    every_env_does_what_it_was_told,
    same_calls_give_same_states,
    reset_forgets_what_was_before,
    the_same_way_leads_to_the_same_place,
    an_env_in_a_batch_is_as_one_alone,
    envs_do_not_touch_one_another,
    resting_arms_change_nothing,
    render_gives_a_frame_or_says_why_not,
    frames_show_the_target,
    close_can_be_called_twice,
    SERVO_CONTRACT,
    *SERVO_CHECKS,
)


@check("sim-render-tried", "warning")
def frames_were_tried(simulator: Simulator, robot: Robot) -> None:
    """`render` gives a frame on this machine. If it does not, drawing could not be tried here."""
    with opened(simulator, robot) as simulation:
        start_at_home(simulation, robot)
        try:
            simulation.render(0, TARGET, 64, 48)
        except UsageError as error:
            raise AssertionError(f"rendering was not tried: {error}") from error


SIMULATOR_WARNINGS: tuple[Check, ...] = (frames_were_tried,)


def _require_there_at_rest(state: State, qpos: Float) -> None:
    error = np.abs(state.qpos - qpos).max()
    require(error < MAX_PLACEMENT_ERROR, f"the joints are {error:.2g} rad from where they were put")
    require((state.qvel == 0.0).all(), f"the joints are not at rest: {state.qvel} rad/s")


def _goes_on(simulator: Simulator, robot: Robot, stood: TrainingState | None) -> tuple[TrainingState, list[State]]:
    """Where the arms stand when one has got into the ground, or where they `stood`; and their states from then on."""
    home, targets = np.tile(robot.home, (NUM_ENVS, 1)), _into_the_ground_and_back(robot)
    with opened(simulator, robot) as simulation:
        log = LoggedSimulation(simulation, robot, NUM_ENVS)
        if stood is None:
            log.reset(home, np.ones(NUM_ENVS, bool))
            for period, qpos in enumerate(targets[:-BACK]):
                log.drive(qpos, PERIOD)
                for env in RESETS.get(period, ()):
                    log.reset(home, np.arange(NUM_ENVS) == env)
            stood = log.state()
        else:
            log.restore(stood)
        return stood, [copied(log.drive(qpos, PERIOD)) for qpos in targets[-BACK:]]


def _into_the_ground_and_back(robot: Robot) -> list[Float]:
    """Joint targets of envs some of which are at home again after some periods, see `RESETS`."""
    way, done, targets = way_into_the_ground(robot), np.zeros(NUM_ENVS, int), []
    for period in range(len(way)):
        targets.append(way[done])
        done += 1
        done[list(RESETS.get(period, ()))] = 0
    for _ in range(BACK):
        done = np.maximum(done - 1, 0)
        targets.append(way[done])
    return targets


def _driven_alike(simulator: Simulator, robot: Robot, num_envs: int) -> list[State]:
    """The states of envs that are all told the same."""
    with opened(simulator, robot, num_envs) as simulation:
        start_at_home(simulation, robot, num_envs)
        targets = [np.repeat(target, num_envs, axis=0) for target in ramps(robot, 1)]
        return [copied(simulation.drive(target, PERIOD)) for target in targets]


def _driven_beside(simulator: Simulator, robot: Robot, share: float) -> list[State]:
    """The states of env 1 while the others go only a share of their way."""
    shares = np.where(np.arange(NUM_ENVS) == 1, 1.0, share)[:, None]
    with opened(simulator, robot) as simulation:
        home = start_at_home(simulation, robot).qpos
        targets = [home + shares * (target - home) for target in ramps(robot, NUM_ENVS)]
        return [part(copied(simulation.drive(target, PERIOD)), np.array([1])) for target in targets]


def _driven_with_rest(simulator: Simulator, robot: Robot, rests: bool) -> tuple[list[State], list[State]]:
    """The states of env 1 while the others may rest, then of all envs after a reset of those others."""
    one = np.arange(NUM_ENVS) == 1
    with opened(simulator, robot) as simulation:
        home = start_at_home(simulation, robot).qpos.copy()
        if rests:
            simulation.rest(~one)  # type: ignore[attr-defined]
        targets = ramps(robot, NUM_ENVS)
        beside = [part(copied(simulation.drive(target, PERIOD)), np.array([1])) for target in targets]
        simulation.reset(home, ~one)
        return beside, [part(copied(simulation.drive(target, PERIOD)), ~one) for target in targets]


def _called_with_changing_arrays(simulator: Simulator, robot: Robot, change: float) -> list[State]:
    """The states of calls with the same joint positions, in arrays that are changed after the call."""
    mask, states = np.ones(NUM_ENVS, bool), []
    with opened(simulator, robot) as simulation:
        reset = partial(simulation.reset, mask=mask)
        drive = partial(simulation.drive, duration=PERIOD)
        for call in (reset, drive, drive, simulation.place, drive):
            qpos = np.tile(robot.home, (NUM_ENVS, 1))
            states.append(copied(call(qpos)))
            require((qpos == robot.home).all() and mask.all(), "the caller's array was changed")
            qpos += change
    return states


def _frame(simulation: Simulation, target: Float, width: int, height: int) -> NDArray[np.uint8] | None:
    """A frame of env 1, the caller's own; None where the simulator says that it cannot."""
    try:
        return np.array(simulation.render(1, target, width, height))
    except UsageError:
        return None
