"""Drake: servos that are as strong as they say, a ground that holds, URDFs that it cannot read."""

import logging

import numpy as np
import pytest

from harness.errors import SimulationDiverged
from tests.plugins.simulators.conftest import PERIOD, home


def test_servo_is_as_fast_as_its_bandwidth(open_arms):
    """After one physics step from rest a joint still lacks 1 / (1 + w dt) of its speed, an implicit step's share.

    The joints are those whose inertia at home is nearly their own: the first one, and the last one.
    """
    simulation = open_arms(1, substeps=1, period=0.005, bandwidth=200.0)
    for joint in (0, 5):
        simulation.place(home(1))
        target = home(1)
        target[0, joint] += 0.001
        assert 1.0 - simulation.drive(target, 0.005).qvel[0, joint] / 0.2 == pytest.approx(0.5, abs=0.02)


def test_number_of_steps_never_wavers(open_arms):
    """After thousands of periods of a duration that rounding makes awkward, each still has its physics steps."""
    simulation = open_arms(1, period=0.1, substeps=3)
    (arm,) = simulation.arms
    for _ in range(3000):
        simulation.drive(home(1), 0.1)
    assert arm.simulator.get_num_discrete_updates() == 9000


def test_it_says_nothing(open_arms, caplog):
    """Drake's warning of soft bodies, of which there are none, is not passed on; its log is as before."""
    level = logging.getLogger("drake").level
    open_arms(1)
    assert caplog.records == []
    assert logging.getLogger("drake").level == level


def test_solver_that_gives_up_ends_the_cell(open_arms):
    """Speeds that are no numbers are told as a diverged simulation."""
    with pytest.raises(SimulationDiverged, match="Drake stops the arm: "):
        open_arms(1).drive(home(1) * np.nan, PERIOD)
