"""PhysX: contact of the end of a period, worlds that are given back, joints that turn without end."""

import resource
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import harness
from harness.errors import UsageError

Call = Callable[..., Any]

ROBOT = harness.load_robot("fd100")
PERIOD = 0.1

pytestmark = pytest.mark.usefixtures("installed")


@pytest.fixture
def simulator():
    """The one that these tests are about."""
    return "physx"


def test_ground_contact_is_that_of_the_end_of_the_period(open_arms, wander, lowest_height):
    """Contact is told of the joint positions that are told with it, not of those of the physics step before."""
    states, _ = wander(open_arms(1), 1, 600)
    told = np.array([state.ground_contact[0] for state in states])
    heights = np.array([lowest_height(state.qpos[0]) for state in states])
    clear = np.abs(heights) > 3e-3  # a loaded contact may hover
    assert told.sum() > 5
    np.testing.assert_array_equal(told[clear], heights[clear] < 0.0)


def test_pressed_on_arm_touches_the_ground(open_arms, home, fallen):
    """An arm that pushes against the ground touches it in every period, and does not get into it."""
    simulation = open_arms(1)
    for share in np.linspace(0.0, 1.0, 20):
        simulation.drive(home(1) + share * (fallen - home(1)), PERIOD)
    for _ in range(20):
        state = simulation.drive(fallen, PERIOD)
        assert state.ground_contact[0]
    assert state.end_effector[0, 2] > -5e-3


def test_arm_that_was_held_up_by_the_ground_catches_up(open_arms, home, fallen):
    """Targets below the ground, asked for over 2 s, are forgotten with the first target above it."""
    simulation = open_arms(1)
    for share in np.linspace(0.0, 1.0, 20):
        simulation.drive(home(1) + share * (fallen - home(1)), PERIOD)
    held = simulation.read().qpos.copy()
    assert np.degrees(np.abs(held - fallen).max()) > 5.0
    above = held + np.radians([[0.0, -5.0, 0.0, 0.0, 0.0, 0.0]])
    state = simulation.drive(above, PERIOD)
    assert np.degrees(np.abs(state.qpos - above).max()) < 0.5


def test_worlds_are_given_back(open_arms, home):
    """A reset makes a new world; a thousand of them take no more memory than the first hundred, to 20 MB."""
    simulation, everyone = open_arms(1), np.ones(1, bool)

    def peak_after(resets):
        for _ in range(resets):
            simulation.reset(home(1), everyone)
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024

    before = peak_after(100)
    assert peak_after(1000) - before < 20


def test_urdf_that_sapien_cannot_read_is_a_usage_error(open_arms):
    """One line names the robot."""
    broken = replace(ROBOT, urdf=ROBOT.urdf.replace('<mass value="', '<mass value="heavy'))
    with pytest.raises(UsageError, match="SAPIEN cannot load the URDF of robot 'fd100': ") as caught:
        open_arms(1, broken)
    assert "\n" not in str(caught.value)
