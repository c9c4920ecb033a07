"""Robots that come with the harness: a folder each, with `robot.toml`, a URDF and a README that names the sources."""

from pathlib import Path

import harness

FD100 = Path(__file__).parent / "fd100"
"""Folder of the FD100, a six-axis articulated arm."""

UNITY_ARM = Path(__file__).parent / "unity_arm"
"""Folder of the five-axis arm that the published experiment used."""


@harness.hookimpl
def register_robots(register: harness.Register) -> None:
    """Announce the robots of this folder."""
    register("fd100", "harness_robots:FD100", summary="FD100, a six-axis arm with nominal link lengths")
    register("unity-arm", "harness_robots:UNITY_ARM", summary="the published experiment's five-axis arm, exact lengths")


@harness.hookimpl
def register_descriptions(register: harness.Register) -> None:
    """Announce the formats that are read beside URDF."""
    register(
        "mjcf",
        "harness_plugins.descriptions.mjcf:Mjcf",
        summary="MuJoCo's own format: an .xml file whose outermost element is <mujoco>",
        requires=("mujoco>=3.17",),
        extra="mujoco",
    )
    register(
        "xacro",
        "harness_plugins.descriptions.xacro_file:XacroFile",
        summary="ROS's macros that become a URDF: .xacro, or a URDF with <xacro:...>",
        requires=("xacro",),
        extra="xacro",
    )
