"""The command."""

from harness.robot_by_name import load_robot


def reaches(robot: str = "fd100") -> None:
    """Say how far an arm reaches, in metres."""
    print(f"{load_robot(robot).reach:.2f} m")  # noqa: T201
