"""The robot: a folder with a URDF, its meshes and a `robot.toml`."""

from pathlib import Path

FOLDER = Path(__file__).parent / "arm"
