"""The robot can be read, moved in every simulator that is installed, and set a task."""

import numpy as np
import pytest
from mesh_arm.robot import FOLDER

from harness import load_registry, load_robot
from harness.task import ReachTask
from harness_plugins.kit import check_contract


@pytest.mark.parametrize("name", ["kinematic", "mujoco", "pybullet"])
def test_moves_in_a_simulator(name: str) -> None:
    """The contract of every simulator, with this arm: its meshes touch the ground, and nothing in the air."""
    spec = load_registry().get("simulators", name)
    if spec.missing:
        pytest.skip(f"{', '.join(spec.missing)} is not installed: {spec.remedy}")
    check_contract("simulator", spec.load()(), load_robot(FOLDER))


def test_contract() -> None:
    """Its files make an arm that can be computed with."""
    check_contract("robot", FOLDER)


def test_joints_and_reach() -> None:
    """What the files say is what the harness reads."""
    robot = load_robot(FOLDER)
    assert robot.joint_names == ("turn", "lift", "bend", "tilt", "roll")
    assert np.isclose(robot.reach, 0.12 + 0.42 + 0.34 + 0.08 + 0.09)


def test_meshes_collide() -> None:
    """Every moving link but the tool has the hull of its mesh."""
    robot = load_robot(FOLDER)
    assert [[shape.kind for shape in shapes] for shapes in robot.joint_shapes] == [["mesh"]] * 5


def test_task() -> None:
    """It reaches targets of the reach task, which scales to the arm."""
    ReachTask().check(load_robot(FOLDER))
