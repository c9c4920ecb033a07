"""From a name or a path to a robot."""

import os
from pathlib import Path

from harness.errors import UsageError
from harness.registry.registry import Registry, load_registry
from harness.robot.robot import Robot, read_robot


def load_robot(name_or_path: str | Path, registry: Registry | None = None) -> Robot:
    """A registered robot, or the one that a path leads to.

    Args:
        name_or_path: ``fd100``; or the path of a URDF, beside which a ``robot.toml`` may lie, or of a folder that holds
            both.
        registry: The plugins; loaded if None.

    Raises:
        UsageError: No such robot, or its files say something that cannot be.
    """
    text = str(name_or_path)
    if is_path(name_or_path) and os.path.exists(text):  # no error, whatever the text
        return read_robot(Path(text))
    plugins = registry or load_registry()
    if is_path(name_or_path) and "robots" not in plugins.kinds_of(text):  # a qualified name looks like a path
        raise UsageError(f"No robot at '{text}': name a URDF, a folder that holds robot.toml, or a registered robot")
    folder: Path = plugins.get("robots", text).load()
    return read_robot(folder)


def is_path(robot: str | Path) -> bool:
    """Whether a robot is given by the path of its files, and not by a registered name."""
    text = str(robot)
    return isinstance(robot, Path) or "/" in text or "\\" in text or text.endswith(".urdf")
