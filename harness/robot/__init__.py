"""A URDF, or what a plugin makes one of, and a robot.toml become a robot."""

from typing import TYPE_CHECKING, Any

from harness.face import look_up
from harness.robot.description import Description, DescriptionFormat
from harness.robot.robot import Robot

if TYPE_CHECKING:
    from harness.robot.energy import read_bodies
    from harness.robot.ground_clearance import Solids, build_solids
    from harness.robot.inverse_kinematics import reach_pose, reach_position
    from harness.robot.kinematics import (
        Chain,
        child_frames,
        end_effector_position,
        forward,
        link_frames,
        rotation_of_axes,
    )
    from harness.robot.meshes import read_mesh
    from harness.robot.robot import load_robot, read_robot
    from harness.robot.servo import Servo
    from harness.robot.shapes import Shape, attach_shapes, read_shapes
    from harness.robot.urdf import parse_urdf, read_chain

__all__ = [
    "Chain",
    "Description",
    "DescriptionFormat",
    "Robot",
    "Servo",
    "Shape",
    "Solids",
    "attach_shapes",
    "build_solids",
    "child_frames",
    "end_effector_position",
    "forward",
    "link_frames",
    "load_robot",
    "parse_urdf",
    "reach_pose",
    "reach_position",
    "read_bodies",
    "read_chain",
    "read_mesh",
    "read_robot",
    "read_shapes",
    "rotation_of_axes",
]

_HOMES = {
    "energy": "read_bodies",
    "ground_clearance": "Solids build_solids",
    "inverse_kinematics": "reach_pose reach_position",
    "kinematics": "Chain child_frames end_effector_position forward link_frames rotation_of_axes",
    "meshes": "read_mesh",
    "robot": "load_robot read_robot",
    "servo": "Servo",
    "shapes": "Shape attach_shapes read_shapes",
    "urdf": "parse_urdf read_chain",
}


def __getattr__(name: str) -> Any:
    return look_up(__name__, _HOMES, name)
