"""What a state tells: shapes, types, finite numbers, and an end effector that fits the joints."""

from itertools import cycle, islice

import numpy as np

from harness.robot import Robot
from harness.simulator import Simulator, State
from harness.testing.simulators.simulations import (
    NUM_ENVS,
    PERIOD,
    copied,
    dive_into_the_ground,
    drive_out_and_back,
    opened,
    poses_near_home,
    ramps,
    start_at_home,
)
from harness.testing.violations import check, require

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
