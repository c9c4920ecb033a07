"""Arms that differ from the drawing."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

from harness.conditions.conditions import Conditions
from harness.conditions.varied_robot import Factors, draw_factors, draw_robot, vary_robot
from harness.robot import Servo, parse_urdf
from harness.robot.energy import read_bodies
from tests.registered import FD100 as ARM

LINKS = len(draw_factors(Conditions(), ARM, 0).masses)


def test_factors_of_one_are_the_robot_itself():
    """Nothing is written anew."""
    ones = Factors((1.0,) * LINKS, (1.0,) * LINKS, 1.0)
    assert vary_robot(ARM, ones) is ARM
    assert draw_factors(Conditions(), ARM, 5) == ones


def test_all_lengths_scale_what_the_joints_carry():
    """Twice as long: the end effector is twice as far from the first joint, and shapes are twice as large."""
    double = vary_robot(ARM, Factors((1.0,) * LINKS, (2.0,) * LINKS, 1.0))
    qpos = default_rng(0).uniform(ARM.lower, ARM.upper, (5, 6))
    first = ARM.chain.T_previous_joint[0, :3, 3]
    assert_allclose(double.end_effector(qpos) - first, 2.0 * (ARM.end_effector(qpos) - first), atol=1e-12)
    assert double.joint_shapes[1][0].size == pytest.approx([2.0 * edge for edge in ARM.joint_shapes[1][0].size])


def test_masses_scale_with_their_inertias():
    """And the base stays as it is."""
    heavy = vary_robot(ARM, Factors((3.0,) * LINKS, (1.0,) * LINKS, 1.0))
    for name, link in parse_urdf(heavy.urdf).links.items():
        drawn = parse_urdf(ARM.urdf).links[name]
        factor = 1.0 if name == "base_link" else 3.0
        for tag, attribute in (("mass", "value"), ("inertia", "ixx")):
            told, before = link.find(f"inertial/{tag}"), drawn.find(f"inertial/{tag}")
            assert float(told.get(attribute)) == pytest.approx(factor * float(before.get(attribute)))
    assert read_bodies(heavy) is not None


def test_factors_stay_within_their_shares_and_differ():
    """Each link has its own; an arm is the same whenever it is drawn."""
    wide = Conditions(mass_variation=0.3, length_variation=0.1)
    drawn = [draw_factors(wide, ARM, number) for number in range(20)]
    masses, lengths = (np.array([getattr(factors, name) for factors in drawn]) for name in ("masses", "lengths"))
    assert 0.2 < np.abs(masses - 1.0).max() <= 0.3
    assert 0.07 < np.abs(lengths - 1.0).max() <= 0.1
    assert len(np.unique(masses)) == masses.size
    assert draw_factors(wide, ARM, 3) == drawn[3]
    assert draw_robot(wide, ARM, 3) is draw_robot(wide, ARM, 3)


def test_friction_is_that_of_the_drives():
    """Of both kinds; a robot that describes no drives has none to vary."""
    servo = Servo(*(np.full(6, number) for number in (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)), 0.0, True)
    rubbing = vary_robot(replace(ARM, servo=servo), Factors((1.0,) * LINKS, (1.0,) * LINKS, 0.5)).servo
    assert_array_equal([rubbing.viscous_friction[0], rubbing.dry_friction[0]], [1.5, 2.0])
    assert_array_equal([rubbing.max_torque[0], rubbing.stiffness[0]], [1.0, 5.0])
    assert vary_robot(replace(ARM, servo=None), Factors((1.0,) * LINKS, (1.0,) * LINKS, 0.5)).servo is None
