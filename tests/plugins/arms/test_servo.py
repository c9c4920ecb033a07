"""Arms that follow references: who is told what, and when."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from harness.simulator import Substeps
from harness_plugins.arms.servo import ServoArms
from tests.registered import FD100 as ROBOT

HOME = np.tile(ROBOT.home, (2, 1))
DELAY = 2
"""Physics steps of 0.005 s in the latency of the FD100's drives."""


class ExactArm:
    """Is where its references are, and writes them down."""

    def __init__(self):
        self.told = []

    def put(self, qpos):
        """At rest there."""
        self.qpos = qpos.copy()

    def follow(self, qpos_ref, qvel_ref):
        """At once."""
        self.told.append((qpos_ref.copy(), qvel_ref.copy()))
        self.qpos = qpos_ref[-1].copy()

    def read(self, state, env):
        """Its place."""
        state.qpos[env] = self.qpos


@pytest.fixture
def simulation():
    """Two of them."""
    return ServoArms(ROBOT, 2, Substeps(20, 0.1), ExactArm)


def test_references_go_from_the_last_target_to_the_next_and_come_late(simulation):
    """Also where an arm is elsewhere than it was told."""
    simulation.drive(HOME + 1.0, 0.1)
    simulation.arms[1].qpos -= 0.5
    simulation.drive(HOME + 3.0, 0.1)
    way = np.concatenate([np.zeros(DELAY), np.linspace(0.0, 1.0, 21)[:-1], np.linspace(1.0, 3.0, 21)[:-1]])[:40]
    speed = np.concatenate([np.zeros(DELAY), np.full(20, 10.0), np.full(20, 20.0)])[:40]
    for arm in simulation.arms:
        positions, speeds = (np.concatenate(part) for part in zip(*arm.told, strict=True))
        assert_allclose(positions, ROBOT.home + way[:, None], atol=1e-12)
        assert_allclose(speeds, np.tile(speed[:, None], ROBOT.dof), atol=1e-9)


def test_part_of_a_period_has_its_part_of_the_steps(simulation):
    """A quarter of it five of twenty."""
    simulation.drive(HOME, 0.025)
    assert [len(arm.told[0][0]) for arm in simulation.arms] == [5, 5]


def test_reset_forgets_what_is_to_come(simulation):
    """In the arms of the mask; the others go on."""
    simulation.drive(HOME + 1.0, 0.1)
    simulation.reset(HOME, np.array([True, False]))
    simulation.drive(HOME, 0.1)
    first, second = (arm.told[1][0][0] for arm in simulation.arms)
    assert_array_equal(first, ROBOT.home)
    assert_allclose(second, ROBOT.home + 0.9)


def test_resting_arms_are_told_nothing(simulation):
    """Until they are reset."""
    simulation.rest(np.array([True, False]))
    simulation.drive(HOME + 1.0, 0.1)
    assert [len(arm.told) for arm in simulation.arms] == [0, 1]
    simulation.reset(HOME, np.array([True, False]))
    simulation.drive(HOME + 1.0, 0.1)
    assert [len(arm.told) for arm in simulation.arms] == [1, 2]
