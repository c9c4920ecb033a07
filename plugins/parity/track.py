"""What a simulation did when it was placed or told a motion, and how far two that did the same are apart."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from harness import Float, Mask
from harness.errors import SimulationDiverged
from harness.files.plain import tells
from harness.robot import Robot
from harness.simulator import Simulation, State

POSES = 64


class Track(NamedTuple):
    """The states before the first control period and after each one. Frame: world."""

    qpos: Float
    """Joint positions, (rows, episodes, dof), [rad]."""
    tip: Float
    """Position of the end effector, (rows, episodes, 3), [m]."""
    contact: Mask
    """Whether a moving link touches the ground, (rows, episodes)."""


def follow(simulation: Simulation, motion: Float, period: float) -> Track:
    """Reset all envs to the first row of `motion` and drive them along the others.

    Args:
        simulation: With as many envs as the motion has episodes.
        motion: Joint targets, (rows, episodes, dof), [rad].
        period: Control period, [s].

    Raises:
        SimulationDiverged: A number is not finite.
    """
    states = [copied(simulation.reset(motion[0], np.ones(motion.shape[1], bool)), 0)]
    states += [copied(simulation.drive(target, period), row) for row, target in enumerate(motion[1:], 1)]
    return stacked(states)


def copied(state: State, row: int) -> State:
    """A state that outlives the simulation's next call.

    Raises:
        SimulationDiverged: A number is not finite; names `row`, the control period.
    """
    copy = State._make(np.array(array) for array in state)
    for name, array in zip(State._fields, copy, strict=True):
        if not np.isfinite(array).all():
            raise SimulationDiverged(f"{name} is not finite after control period {row}")
    return copy


def stacked(states: list[State]) -> Track:
    """One after another."""
    return Track(
        np.stack([state.qpos for state in states]),
        np.stack([state.end_effector for state in states]),
        np.stack([state.ground_contact for state in states]),
    )


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


@tells("max_tip_error_m", "mean_tip_error_m", "max_joint_error_rad")
@dataclass(frozen=True, eq=False)
class Drift:
    """Distance of tips and joints of two tracks.

    Attributes:
        tip: (rows, episodes), [m].
        joint: That of the joint farthest off, (rows, episodes), [rad]; of a slide the share of its range, as of a turn.
    """

    tip: Float
    joint: Float

    @property
    def max_tip_error_m(self) -> float:
        """Over all episodes and rows, [m]."""
        return float(self.tip.max())

    @property
    def mean_tip_error_m(self) -> float:
        """Over all episodes and rows but the first, where nobody has moved yet, [m]."""
        return float(self.tip[1:].mean())

    @property
    def max_joint_error_rad(self) -> float:
        """Over all episodes, rows and joints, [rad]."""
        return float(self.joint.max())

    @property
    def curves(self) -> dict[str, Float]:
        """Over the episodes at each row, the start included: (rows,) each."""
        return {
            "max_tip_error_m": self.tip.max(axis=1),
            "mean_tip_error_m": self.tip.mean(axis=1),
            "max_joint_error_rad": self.joint.max(axis=1),
        }


def drift_between(first: Track, second: Track, per_radian: Float | float = 1.0) -> Drift:
    """How far two tracks of one motion are apart; `per_radian` is that of `harness.robot.Robot`, (dof,)."""
    tip = np.linalg.norm(first.tip - second.tip, axis=-1)
    return Drift(np.asarray(tip), (np.abs(first.qpos - second.qpos) / per_radian).max(axis=-1))
