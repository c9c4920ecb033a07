"""Where a robot's description comes from: its `robot.toml`, its file, and the text of its URDF."""

from dataclasses import dataclass
from pathlib import Path

from harness.errors import UsageError
from harness.files.bounded import read_text
from harness.robot.settings import FILE, RobotSettings, read_settings

MOST_BYTES = 4 * 2**20
"""The most bytes of a URDF: 200 for each of the elements that it may have. A humanoid's has a fifth of a megabyte."""


@dataclass(frozen=True)
class Source:
    """A robot as it was given.

    Attributes:
        settings: The robot.toml, empty where there is none.
        path: The file that describes the arm.
        text: Its URDF.
        folder: Where the names of meshes in it start.
        warnings: What to know about how it was read, a line each.
    """

    settings: RobotSettings
    path: Path
    text: str
    folder: Path
    warnings: tuple[str, ...] = ()


def read_source(path: Path) -> Source:
    """The description at `path`: a folder with a robot.toml, or a URDF beside which one may lie.

    Raises:
        UsageError: A file cannot be read; the message names it.
    """
    settings, file = _find_files(path)
    return Source(settings, file, _read_text(file), file.parent)


def _find_files(path: Path) -> tuple[RobotSettings, Path]:
    """The robot.toml, empty where there is none, and the URDF's path."""
    if path.is_dir():
        return _find_in_folder(path)
    beside = path.parent / FILE
    if beside.is_file():
        settings = read_settings(beside)
        if settings.text("urdf") in {None, path.name}:
            return settings, path
    return RobotSettings(beside), path


def _find_in_folder(folder: Path) -> tuple[RobotSettings, Path]:
    if not (folder / FILE).exists():
        raise UsageError(f"{folder}: no {FILE} in it. Give the path of a URDF, or write a {FILE} that names one.")
    settings = read_settings(folder / FILE)
    name = settings.text("urdf")
    if name is None:
        raise UsageError(
            f"{settings.path}: missing urdf. Name the URDF's file, or give its path instead of the folder."
        )
    return settings, folder / name


def _read_text(path: Path) -> str:
    try:
        return read_text(path, MOST_BYTES)
    except OSError as error:
        raise UsageError(f"{path}: cannot be read ({error.strerror}). A robot is a URDF and its {FILE}.") from error
    except UnicodeDecodeError as error:
        raise UsageError(f"{path}: is not UTF-8 text ({error.reason}). Save it as UTF-8.") from error
