"""Registers the robot. Keep it light: every `harness` command imports it."""

import harness

harness_api = 2


@harness.hookimpl
def register_robots(register: harness.Register) -> None:
    """Announce the folder of the arm."""
    register("mesh-arm", "mesh_arm.robot:FOLDER", summary="five joints, links by STL meshes")
