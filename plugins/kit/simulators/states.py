"""What a state holds after `reset` and `place`, what an arm on the ground is told, and what a frame shows."""

from collections.abc import Callable
from itertools import cycle, islice

import numpy as np
from numpy.typing import NDArray

from harness import Float
from harness.env.solid_probes import find_missing, missing_in_words, probes_of
from harness.errors import UsageError
from harness.robot import Robot
from harness.simulator import Simulation, Simulator, State

from ..contract import check, require
from .simulations import (
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
    way_into_the_ground,
)

HORIZON = 100
"""Control periods of a whole episode of the default task, ``fd100-reach``."""
MAX_OFFSET = 1e-6
"""The largest offset of the end effector from where the kinematics put it, [m]."""


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
    """No number is NaN or infinite in an episode of 100 periods, neither in free motion nor against the ground."""
    with opened(simulator, robot) as simulation:
        _require_finite([start_at_home(simulation, robot)])
        for targets in islice(cycle(ramps(robot, NUM_ENVS)), HORIZON):
            _require_finite([simulation.drive(targets, PERIOD)])
        _require_finite(dive_into_the_ground(simulation, robot))


@check("sim-end-effector")
def end_effector_is_that_of_the_robot(simulator: Simulator, robot: Robot) -> None:
    """The end effector is where `robot.end_effector` puts it for the joint positions of the same state."""
    with opened(simulator, robot) as simulation:
        driven = drive_out_and_back(simulation, robot)
        for state in [*driven, copied(simulation.place(poses_near_home(robot, NUM_ENVS)))]:
            error = np.linalg.norm(state.end_effector - robot.end_effector(state.qpos), axis=-1).max()
            require(error < MAX_OFFSET, f"the end effector is {error:.2g} m from the robot's kinematics")


def _require_finite(states: list[State]) -> None:
    for state in states:
        for name, array in zip(State._fields, state, strict=True):
            require(np.isfinite(array).all(), "{} is {}", name, array)


MAX_PLACEMENT_ERROR = 1e-6
"""[rad], or [m] where a joint slides."""


@check("sim-reset")
def reset_puts_the_arm_there_at_rest(simulator: Simulator, robot: Robot) -> None:
    """After `reset` the joints of the masked envs rest where the call put them, also after a motion."""
    _require_there_at_rest(simulator, robot, lambda sim, qpos: sim.reset(qpos, np.ones(NUM_ENVS, bool)))


@check("sim-place")
def place_puts_the_arm_there_at_rest(simulator: Simulator, robot: Robot) -> None:
    """After `place` the joints of all envs rest where the call put them, also after a motion."""
    _require_there_at_rest(simulator, robot, lambda sim, qpos: sim.place(qpos))


@check("sim-reset-mask")
def reset_leaves_the_other_envs_alone(simulator: Simulator, robot: Robot) -> None:
    """`reset` changes nothing in the envs outside its mask."""
    mask = np.arange(NUM_ENVS) == 0
    with opened(simulator, robot) as simulation:
        before = drive_out_and_back(simulation, robot)[-1]
        after = simulation.reset(poses_near_home(robot, NUM_ENVS), mask)
        require(same([part(before, ~mask)], [part(after, ~mask)]), "the envs outside the mask changed")


def _require_there_at_rest(simulator: Simulator, robot: Robot, put: Callable[[Simulation, Float], State]) -> None:
    """See that arms are where they were put after a motion, and rest."""
    qpos = poses_near_home(robot, NUM_ENVS)
    with opened(simulator, robot) as simulation:
        drive_out_and_back(simulation, robot)
        state = copied(put(simulation, qpos))
    error = np.abs(state.qpos - qpos).max()
    require(error < MAX_PLACEMENT_ERROR, f"the joints are {error:.2g} rad or m from where they were put")
    require((state.qvel == 0.0).all(), f"the joints are not at rest: {state.qvel} rad/s or m/s")


STAYS = 0.1
"""So far from home, [rad] or a slide's share of it, is an arm at most that stays there; see `Robot.per_radian`."""


@check("sim-ground-contact")
def ground_contact_is_seen(simulator: Simulator, robot: Robot) -> None:
    """An arm that is driven into the ground touches it."""
    with opened(simulator, robot) as simulation:
        contacts = [state.ground_contact for state in dive_into_the_ground(simulation, robot)]
        require(np.any(contacts, axis=0).all(), "the arm was driven into the ground and touched nothing")


@check("sim-solids")
def every_solid_touches_the_ground(simulator: Simulator, robot: Robot) -> None:
    """Where one collision shape alone is in the ground, and all others above it, the arm touches: none was dropped."""
    with opened(simulator, robot, 1) as simulation:
        probes = probes_of(robot)
        missing = find_missing(simulation, probes)
    touches_nothing = len(missing) == len(probes) > 1  # another check says it
    require(
        not missing or touches_nothing,
        f"{missing_in_words(missing)}: where it alone is in the ground, the arm touches nothing",
    )


@check("sim-no-false-contact")
def no_ground_contact_in_the_air(simulator: Simulator, robot: Robot) -> None:
    """An arm at home, or moving about it, does not touch the ground."""
    with opened(simulator, robot) as simulation:
        for state in drive_out_and_back(simulation, robot):
            require(not state.ground_contact.any(), "the arm touches the ground in the air")


@check("sim-contact-per-env")
def ground_contact_is_the_envs_own(simulator: Simulator, robot: Robot) -> None:
    """If one arm is in the ground, only its own env reports contact: the envs that stay at home touch nothing."""
    with opened(simulator, robot) as simulation:
        home = start_at_home(simulation, robot)
        targets = home.qpos.copy()
        for qpos in way_into_the_ground(robot):
            targets[0] = qpos
            state = copied(simulation.drive(targets, PERIOD))
            contact, stays = (
                state.ground_contact,
                (np.abs(state.qpos - home.qpos) < STAYS * robot.per_radian).all(axis=1),
            )
            new = contact & ~home.ground_contact & stays  # who left home was told so: another check says it
            told = f"env 0 alone goes into the ground, and ground_contact goes from {home.ground_contact.tolist()} to "
            require(not new[1:].any(), f"{told}{contact.tolist()}: the others stand at home")


TARGET = np.array([0.6, 0.2, 0.5])
"""The target of the frames, [m]."""


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


@check("sim-render-tried", "warning")
def frames_were_tried(simulator: Simulator, robot: Robot) -> None:
    """`render` gives a frame on this machine. If it does not, drawing could not be tried here."""
    with opened(simulator, robot) as simulation:
        start_at_home(simulation, robot)
        try:
            simulation.render(0, TARGET, 64, 48)
        except UsageError as error:
            raise AssertionError(f"rendering was not tried: {error}") from error


def _frame(simulation: Simulation, target: Float, width: int, height: int) -> NDArray[np.uint8] | None:
    """A frame of env 1, the caller's own; None where the simulator says that it cannot."""
    try:
        return np.array(simulation.render(1, target, width, height))
    except UsageError:
        return None
