"""A URDF, or what a plugin makes one of, and a robot.toml become a robot."""

from harness.robot.description import Description, DescriptionFormat
from harness.robot.robot import Robot

__all__ = ["Description", "DescriptionFormat", "Robot"]
