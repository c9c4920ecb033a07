"""Built-in formats of robots beside URDF."""

import harness


@harness.hookimpl
def register_descriptions(register: harness.Register) -> None:
    """Announce the built-in formats."""
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
