"""Tracks: what a simulation did, copied, and only finite numbers."""

import numpy as np
import pytest

from harness.errors import SimulationDiverged
from harness_plugins.kit import IdealSimulator
from harness_plugins.parity.motions import smooth_motions
from harness_plugins.parity.track import follow


def test_the_ideal_arm_follows_exactly(robot):
    """Its track is the motion, the start included."""
    motion = smooth_motions(robot, 0, 3, 20, 0.1).motions
    track = follow(IdealSimulator().open(robot, 3, 0.1), motion, 0.1)
    np.testing.assert_array_equal(track.qpos, motion)
    np.testing.assert_array_equal(track.tip, robot.end_effector(motion))
    assert (track.contact.shape, track.contact.dtype) == ((21, 3), bool)


def test_a_number_that_is_not_finite_is_told(robot, toolbox):
    """With its name and the control period."""
    simulation = toolbox.exploding.open(robot, 2, 0.1)
    with pytest.raises(SimulationDiverged, match="qpos is not finite after control period 3"):
        follow(simulation, smooth_motions(robot, 0, 2, 20, 0.1).motions, 0.1)


def test_arrays_that_the_simulation_writes_over_are_copied(robot):
    """A track of a simulation that always returns the same arrays holds different rows."""
    simulation = IdealSimulator().open(robot, 1, 0.1)
    held = simulation.read()
    fresh = simulation.state

    def state():
        for kept, new in zip(held, fresh(), strict=True):
            kept[...] = new
        return held

    simulation.state = state
    motion = smooth_motions(robot, 0, 1, 20, 0.1).motions
    np.testing.assert_array_equal(follow(simulation, motion, 0.1).qpos, motion)
