"""A URDF and a robot.toml become a robot."""

from harness.robot.robot import Robot

__all__ = ["Robot"]
