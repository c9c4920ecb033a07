"""Where a robot's description comes from: its `robot.toml`, its file, and the text of its URDF."""

import errno
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from harness.errors import UsageError
from harness.files.bounded import read_bytes, read_text
from harness.registry.registry import Registry, load_registry
from harness.robot.description import Description, read_description
from harness.robot.settings import ARGUMENTS, FILE, RobotSettings, read_settings

MOST_BYTES = 4 * 2**20
"""The most bytes of a URDF: 200 for each of the elements that it may have. A humanoid's has a fifth of a megabyte."""
COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)


@dataclass(frozen=True)
class Source:
    """A robot as it was given.

    Attributes:
        settings: The robot.toml, empty where there is none.
        path: The file that describes the arm.
        text: Its URDF.
        folder: Where the names of meshes in it start.
        warnings: What to know about how it was read, a line each.
        described: What a reader of another format understood of the file; empty of a URDF.
    """

    settings: RobotSettings
    path: Path
    text: str
    folder: Path
    warnings: tuple[str, ...] = ()
    described: Description = field(default_factory=lambda: Description(""))


def read_source(path: Path, registry: Registry | None = None) -> Source:
    """The description at `path`: a folder with a robot.toml, or a file beside which one may lie.

    Args:
        path: The folder, or the file.
        registry: Has the readers of what is no URDF; loaded if None.

    Raises:
        UsageError: A file cannot be read; the message names it.
    """
    settings, file = _find_files(path)
    arguments = settings.texts(ARGUMENTS)
    if not _may_be_urdf(file):
        described = read_description(file, arguments, registry or load_registry())
        if described is not None:
            return Source(settings, file, described.urdf, file.parent, described.warnings, described)
    if arguments:
        raise UsageError(f"{settings.path}: {ARGUMENTS} are given, and {file.name} is a URDF, which takes none.")
    return Source(settings, file, _read_text(file), file.parent)


def _may_be_urdf(path: Path) -> bool:
    """Whether a file is a URDF, or cannot be read at all."""
    try:
        data = COMMENT.sub(b"", read_bytes(path, MOST_BYTES))
    except OSError as error:
        return error.errno != errno.EFBIG
    return path.suffix.lower() != ".xacro" and b"<robot" in data and b"<xacro:" not in data


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


def package_folders(name: str, folder: Path) -> Iterator[Path]:
    """The folders of a ROS package, likeliest first.

    Looked at are those around `folder`, those beside them, those that ROS_PACKAGE_PATH lists and those in them, and
    ``share`` in those that AMENT_PREFIX_PATH lists. A folder around it is also known by its ``package.xml``.

    Args:
        name: Of the package.
        folder: Where it is asked for.
    """
    around = (folder.absolute(), *folder.absolute().parents)
    listed = [Path(place) for place in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if place]
    installed = [Path(place, "share") for place in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if place]
    yield from (place for place in (*around, *listed) if name in {place.name, _named_by(place / "package.xml")})
    places = (place / name for place in (*around, *listed, *installed))
    yield from (place for place in places if os.path.isdir(place))


def _named_by(manifest: Path) -> str:
    """The name that a package.xml gives its package; empty without such a file."""
    try:
        found = re.search(r"<name>\s*([^<\s]+)\s*</name>", read_text(manifest, MOST_BYTES))
    except (OSError, UnicodeDecodeError):
        return ""
    return found[1] if found else ""
