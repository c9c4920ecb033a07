"""MuJoCo: the threads of a batch do not show; what it cannot load is named."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import harness
from harness.errors import UsageError
from harness.robot.robot import read_robot
from harness_plugins.simulators.mujoco import Mujoco

Call = Callable[..., Any]


@pytest.fixture
def simulator() -> str:
    """The one that these tests are about."""
    return "mujoco"


def test_number_of_threads_does_not_show(open_arms: Call, wander: Call, assert_same: Call):
    """One thread and two give the same states, bit for bit."""
    assert_same(*(wander(open_arms(7, threads=threads), 7, 60)[0] for threads in (1, 2)))


def test_more_threads_than_arms(open_arms: Call, home: Call):
    """Threads without an arm are no error."""
    assert open_arms(2, threads=4).drive(home(2), 0.1).qpos.shape == (2, 6)


def test_a_mesh_without_a_volume_is_refused_with_its_link(tmp_path: Path):
    """MuJoCo computes no hull of points in a plane: the error names the link whose mesh is flat."""
    (tmp_path / "flat.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
    flat = '<collision><geometry><mesh filename="flat.obj"/></geometry></collision></link>'
    (tmp_path / "arm.urdf").write_text(harness.load_robot("fd100").urdf.replace("</link>", flat, 2))
    robot = read_robot(tmp_path / "arm.urdf")
    second = list(robot.link_shapes)[1]
    with pytest.raises(UsageError, match=rf"collision of link ({next(iter(robot.link_shapes))}|{second}) "):
        Mujoco().open(robot, 1, 0.1)
