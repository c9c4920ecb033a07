"""Arms of which something is drawn."""

import numpy as np
import pytest

from harness.record.scene import scene_from_json
from harness.robot.robot import read_robot
from harness.scene.scene import scene_of, surface
from tests.registered import FD100
from tests.robot.test_meshes import binary_stl

LINK = """<link name="{name}">
  <visual><origin xyz="0 0 0.1" rpy="0 0.3 0"/><geometry><mesh filename="{file}" scale="1 1 -2"/></geometry>
    {material}</visual>
  <collision><geometry>{solid}</geometry></collision>
</link>"""
JOINT = """<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>
  <origin xyz="0.1 0 0.3" rpy="0.2 0 0.1"/><axis xyz="0 1 0"/>
  <limit lower="-1" upper="1" velocity="1" effort="10"/></joint>"""


def meshed(
    folder,
    files=("part.stl",) * 4,
    solid='<sphere radius="0.05"/>',
    material='<material name="red"/>',
):
    """An arm of three joints, one of which slides; each link has a mesh that is mirrored, and a ball that collides."""
    (folder / "part.stl").write_bytes(binary_stl(_box_corners()))
    (folder / "flat.stl").write_bytes(binary_stl(_box_corners() * np.float32([1.0, 1.0, 0.0])))
    (folder / "empty.stl").write_bytes(binary_stl(_box_corners()[:0]))
    (folder / "part.dae").write_text("<COLLADA/>")
    said = {"solid": solid, "material": material}
    links = "".join(LINK.format(name=f"link{number}", file=file, **said) for number, file in enumerate(files))
    kinds = ("revolute", "prismatic", "revolute")
    joints = "".join(
        JOINT.format(name=f"joint{number}", kind=kind, parent=f"link{number}", child=f"link{number + 1}")
        for number, kind in enumerate(kinds)
    )
    red = '<material name="red"><color rgba="1 0 0 1"/></material>'
    (folder / "arm.urdf").write_text(f'<robot name="arm">{red}{links}{joints}</robot>')
    return read_robot(folder / "arm.urdf")


def _box_corners():
    box = surface("box", (0.1, 0.05, 0.2))
    return box.vertices[box.faces].astype(np.float32)


@pytest.fixture(params=["fd100", "meshes"])
def robot(request, tmp_path):
    """The FD100, and an arm of meshes."""
    return FD100 if request.param == "fd100" else meshed(tmp_path)


@pytest.fixture
def scene(robot):
    """What a cell's folder says of it."""
    return scene_from_json(scene_of(robot).to_json())
