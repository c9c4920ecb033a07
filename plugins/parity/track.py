"""What a simulation did when it was told a motion."""

from typing import NamedTuple

import numpy as np

from harness.arrays import Float, Mask
from harness.errors import SimulationDiverged
from harness.simulator import Simulation, State


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
