"""A URDF, or what a plugin makes one of, and a robot.toml become a robot."""

from typing import TYPE_CHECKING

from harness.face import face_of
from harness.robot.description import Description as Description, DescriptionFormat as DescriptionFormat
from harness.robot.robot import Robot as Robot

if TYPE_CHECKING:
    from harness.robot.energy import read_bodies as read_bodies
    from harness.robot.ground_clearance import Solids as Solids, build_solids as build_solids
    from harness.robot.joint_limits import Servo as Servo
    from harness.robot.kinematics import (
        Chain as Chain,
        child_frames as child_frames,
        end_effector_position as end_effector_position,
        forward as forward,
        link_frames as link_frames,
        reach_pose as reach_pose,
        reach_position as reach_position,
        rotation_of_axes as rotation_of_axes,
    )
    from harness.robot.meshes import read_mesh as read_mesh
    from harness.robot.robot import load_robot as load_robot, read_robot as read_robot
    from harness.robot.shapes import Shape as Shape, attach_shapes as attach_shapes, read_shapes as read_shapes
    from harness.robot.urdf import parse_urdf as parse_urdf, read_chain as read_chain
else:
    __all__, __getattr__ = face_of(__name__, __file__)
