"""What the simulator checks do with a simulation, and how they compare what it tells."""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from harness import Float, Mask
from harness.motion.motion import MoveJ
from harness.robot import Robot
from harness.robot.kinematics import reach_position
from harness.simulator import Simulation, Simulator, State

from ..contract import require

PERIOD = 0.1
"""The period of control, [s]."""
NUM_ENVS = 3


@contextmanager
def opened(simulator: Simulator, robot: Robot, num_envs: int = NUM_ENVS) -> Iterator[Simulation]:
    """A simulation that is closed at the end."""
    simulation = simulator.open(robot, num_envs, PERIOD)
    try:
        yield simulation
    finally:
        simulation.close()


def start_at_home(simulation: Simulation, robot: Robot, num_envs: int = NUM_ENVS) -> State:
    """Reset all envs to the home pose."""
    return copied(simulation.reset(np.tile(robot.home, (num_envs, 1)), np.ones(num_envs, bool)))


def drive_out_and_back(simulation: Simulation, robot: Robot, num_envs: int = NUM_ENVS) -> list[State]:
    """Start at home and follow `ramps`; the state at home and one per period."""
    home = start_at_home(simulation, robot, num_envs)
    return [home, *(copied(simulation.drive(target, PERIOD)) for target in ramps(robot, num_envs))]


def dive_into_the_ground(simulation: Simulation, robot: Robot) -> list[State]:
    """Start at home and go straight, in joint space, to 10 cm below the ground; one state per period."""
    way, num_envs = way_into_the_ground(robot), len(start_at_home(simulation, robot).qpos)
    return [copied(simulation.drive(np.tile(qpos, (num_envs, 1)), PERIOD)) for qpos in way]


def way_into_the_ground(robot: Robot) -> Float:
    """Joint positions from home, straight in joint space, to 10 cm below the ground, (periods, dof)."""
    (way,) = _pose_below_the_ground(robot) - robot.home
    periods = int(np.ceil((np.abs(way) / (0.5 * robot.max_speed * PERIOD)).max()))
    shares = np.arange(1, periods + 1) / periods
    positions: Float = robot.home + shares[:, None] * way
    return positions


def _pose_below_the_ground(robot: Robot) -> Float:
    """Joint positions, (1, dof), with the end effector below the ground: in front of the arm, or under its home."""
    places = [(share * robot.reach, 0.0) for share in (0.6, 0.4, 0.2)] + [robot.end_effector(robot.home)[:2]]
    below = np.array([[x, y, -0.1] for x, y in places])
    goals, reached = reach_position(robot, below, np.tile(robot.home, (len(below), 1)))
    require(reached.any(), f"the arm reaches none of {below.tolist()} m in the ground: choose another for these checks")
    goal: Float = goals[reached][:1]
    return goal


def ramps(robot: Robot, num_envs: int) -> list[Float]:
    """Joint targets from home out and back at 80 % of the speed and 60 % of the acceleration, NOTE Table I."""
    motion = MoveJ.within_limits(robot, speed=0.8, acceleration=0.6, period=PERIOD)
    qpos, qvel = np.tile(robot.home, (num_envs, 1)), np.zeros((num_envs, robot.dof))
    targets = []
    for direction in [1.0] * 4 + [-1.0] * 8 + [1.0] * 4:
        (qpos,), qvel, _ = motion.advance(qpos, qvel, direction * turns(robot, num_envs))
        targets.append(qpos)
    return targets


def turns(robot: Robot, num_envs: int) -> Float:
    """Ways to turn, 1 or -1, (num_envs, dof): neighbouring joints and neighbouring envs against one another."""
    return np.where((np.arange(num_envs)[:, None] + np.arange(robot.dof)) % 2, -1.0, 1.0)


def poses_near_home(robot: Robot, num_envs: int) -> Float:
    """Joint positions, (num_envs, dof), all of them different."""
    noise = np.random.default_rng(0).uniform(-0.2, 0.2, (num_envs, robot.dof)) * robot.per_radian
    return np.minimum(np.maximum(robot.home + noise, robot.lower), robot.upper)


def copied(state: State) -> State:
    """A state that outlives the simulation's next call."""
    return State._make(np.array(array) for array in state)


def same(first: list[State], second: list[State]) -> bool:
    """Whether two lists of states hold the same numbers; what is not a number is the same as itself."""
    return all(
        np.array_equal(old, new, equal_nan=True)
        for one, other in zip(first, second, strict=True)
        for old, new in zip(one, other, strict=True)
    )


def part(state: State, envs: Mask | NDArray[np.intp]) -> State:
    """The state of some envs, given by a mask or by their numbers."""
    return State._make(array[envs] for array in state)
