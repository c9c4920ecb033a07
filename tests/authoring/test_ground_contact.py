"""Ground contact by name of the robot, without an engine."""

import numpy as np
import pytest
from numpy.random import default_rng
from numpy.testing import assert_array_equal

import harness
from harness.robot import link_frames
from harness.simulator import GroundContact
from tests.refusals import refused

ROBOTS = ("fd100", "unity-arm")
RNG = default_rng(3)


def _poses(robot, count=200):
    return RNG.uniform(robot.lower, robot.upper, (count, robot.dof))


@pytest.mark.parametrize("name", ROBOTS)
def test_contact_is_a_clearance_below_zero(name):
    """In every pose; both happen."""
    robot = harness.load_robot(name)
    contact, qpos = GroundContact(robot), _poses(robot)
    touches = contact(qpos)
    assert_array_equal(touches, contact.clearance(qpos) < 0.0)
    assert 0 < touches.sum() < len(qpos)


@pytest.mark.parametrize("name", ROBOTS)
def test_it_says_what_the_kinematic_simulator_says(name):
    """Of the same poses, one simulator beside the other."""
    env = harness.make_env("kinematic", robot=name, num_envs=50)
    qpos = _poses(env.robot, 50)
    assert_array_equal(GroundContact(env.robot)(qpos), env.simulation.place(qpos).ground_contact)
    env.close()


def test_the_arm_is_lowest_somewhere_below_its_joints():
    """No frame of a joint is lower than the lowest point of the shapes around it."""
    robot = harness.load_robot("fd100")
    qpos = _poses(robot)
    heights = link_frames(robot.chain, qpos)[1:, 2, 3]  # the first joint turns inside the base
    assert (GroundContact(robot).clearance(qpos) <= heights.min(axis=0) + 1e-9).all()


def test_another_shape_is_a_usage_error():
    """It says what was given."""
    with refused(r"\(1, 5\).*6"):
        GroundContact(harness.load_robot("fd100"))(np.zeros((1, 5)))
