"""A URDF, or what a plugin makes one of, and a robot.toml become a robot."""

from typing import TYPE_CHECKING

from harness.face import face_of
from harness.robot.description import Description as Description, DescriptionFormat as DescriptionFormat
from harness.robot.robot import Robot as Robot

if TYPE_CHECKING:
    from harness.robot.ground_clearance import build_solids as build_solids
    from harness.robot.joint_limits import Servo as Servo
    from harness.robot.kinematics import (
        forward as forward,
        link_frames as link_frames,
        reach_position as reach_position,
        rotation_of_axes as rotation_of_axes,
    )
    from harness.robot.meshes import read_mesh as read_mesh
    from harness.robot.packages import package_folders as package_folders
    from harness.robot.shapes import Shape as Shape, read_surface as read_surface
    from harness.robot.urdf import BoundedBuilder as BoundedBuilder, parse_urdf as parse_urdf
else:
    __all__, __getattr__ = face_of(__name__)
