"""Whether a simulation's arm is the robot: placed anywhere, where are its joints and its tip?"""

from typing import NamedTuple

import numpy as np

from harness.arrays import Float
from harness.robot import Robot
from harness.simulator import Simulation

from .track import Track, copied, stacked

POSES = 64


class Placement(NamedTuple):
    """The largest errors over all poses."""

    error_m: float
    """The error of the tip, against the robot's own forward kinematics, [m]."""
    error_rad: float
    """The error of a joint, against where it was placed, [rad]; of a slide as in `harness.robot.Robot.per_radian`."""


def random_poses(robot: Robot, seed: int, episodes: int) -> Float:
    """At least `POSES` poses, uniform within the joint ranges: (rounds, episodes, dof), [rad]."""
    rounds = -(-POSES // episodes)
    rng = np.random.default_rng([seed, 2])
    return rng.uniform(robot.lower, robot.upper, (rounds, episodes, robot.dof))


def place_at(simulation: Simulation, poses: Float) -> Track:
    """The states at `poses`, (rounds, episodes, dof), [rad].

    Raises:
        SimulationDiverged: A number is not finite.
    """
    return stacked([copied(simulation.place(qpos), row) for row, qpos in enumerate(poses)])


def placement_of(placed: Track, robot: Robot, poses: Float) -> Placement:
    """How far the states are from `poses`, (rounds, episodes, dof), [rad]."""
    tip_error = np.linalg.norm(placed.tip - robot.end_effector(poses), axis=-1)
    return Placement(float(tip_error.max()), float((np.abs(placed.qpos - poses) / robot.per_radian).max()))
