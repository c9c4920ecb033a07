"""The simulator keeps its contract, and its arms have mass."""

import numpy as np
import pytest

from harness import load_robot
from harness_plugins.kit import check_contract

pytest.importorskip("pinocchio", reason="pinocchio is not installed: pip install pin")

from pinocchio_simulator.simulator import Pinocchio


@pytest.mark.parametrize("robot", ["fd100", "unity-arm"])
def test_contract(robot: str) -> None:
    """It tracks, touches, resets and repeats as the harness relies on."""
    check_contract("simulator", Pinocchio(), load_robot(robot))


def test_joints_move_one_another() -> None:
    """A joint that is told to stay gives way a little when its neighbour starts: there is dynamics."""
    robot = load_robot("fd100")
    simulation = Pinocchio().open(robot, 1, 0.1)
    start = simulation.read().qpos
    turned = simulation.drive(start + np.array([0.0, 0.1, 0.0, 0.0, 0.0, 0.0]), 0.1).qpos - start
    assert 1e-6 < abs(turned[0, 2]) < 0.01
    assert turned[0, 1] == pytest.approx(0.1, abs=0.01)
